"""A URDF as pinocchio alone reads it, and q by hand in it: what robots are compared with."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from importlib.metadata import files
from pathlib import Path

import numpy as np
import pinocchio as pin

from lexstack.robots import RobotModel


def urdfs() -> dict[str, Path]:
    """Return every URDF of example-robot-data, by its path below ``robots/``."""
    found = [Path(str(each.locate())) for each in files("example-robot-data") or []]
    return {
        path.as_posix().split("/robots/", 1)[1]: path.resolve()
        for path in sorted(found)
        if path.suffix == ".urdf"
    }


class PlainUrdf:
    """The whole URDF, none of its joints locked, continuous ones as (cos, sin)."""

    def __init__(self, path: Path, robot: RobotModel) -> None:
        """Read the file; a robot that drives stands on a planar joint here."""
        self.robot = robot
        if robot.has_base:
            self.model = pin.buildModelFromUrdf(str(path), pin.JointModelPlanar())
        else:
            self.model = pin.buildModelFromUrdf(str(path))
        self.data = self.model.createData()
        tree = ET.parse(path).getroot()
        self.mimics = {}
        for joint in tree.findall("joint"):
            mimic = joint.find("mimic")
            if mimic is not None:
                factor, offset = mimic.get("multiplier", "1"), mimic.get("offset", "0")
                self.mimics[joint.get("name")] = mimic.get("joint"), float(factor), float(offset)
        arm = robot.config.arm
        mount = pin.SE3(pin.rpy.rpyToMatrix(*arm.mount.rpy), np.array(arm.mount.xyz))
        pose = robot.mounting
        self.place = pin.SE3(pose.rotation, pose.position) * mount
        self.slopes = self._slopes()

    def _of(self, name: str) -> tuple[str, float, float]:
        """Return whom a joint follows at last: ``factor * q + offset``."""
        if name not in self.mimics or name in self.robot.config.arm.fixed:
            return name, 1.0, 0.0
        joint, factor, offset = self.mimics[name]
        primary, inner, shift = self._of(joint)
        return primary, factor * inner, factor * shift + offset

    def _slopes(self) -> np.ndarray:
        """Return d v / d chi of the joints, all but the base's, shape (nv, n)."""
        slopes = np.zeros((self.model.nv, self.robot.n))
        for i in range(1, self.model.njoints):
            name, factor, _ = self._of(self.model.names[i])
            if name in self.robot.joints:
                slopes[self.model.joints[i].idx_v, self.robot.joints.index(name)] = factor
        return slopes

    def set(self, q: np.ndarray) -> None:
        """Go to a configuration of the robot, shape (nq,)."""
        values = {
            **self.robot.config.arm.fixed,
            **dict(zip(self.robot.coordinates, q, strict=True)),
        }
        full = pin.neutral(self.model)
        self.map = self.slopes.copy()
        for i in range(1, self.model.njoints):
            joint = self.model.joints[i]
            if joint.nv == 3:  # the base: pinocchio's velocities are in its own frame
                cos, sin = np.cos(q[2]), np.sin(q[2])
                full[joint.idx_q : joint.idx_q + 4] = q[0], q[1], cos, sin
                if self.robot.differential:
                    self.map[:3, :2] = [[1.0, 0.0], [0.0, 0.0], [0.0, 1.0]]
                else:
                    self.map[:3, :3] = [[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]]
                continue
            name, factor, offset = self._of(self.model.names[i])
            value = factor * values[name] + offset
            if joint.nq == 2:
                full[joint.idx_q : joint.idx_q + 2] = np.cos(value), np.sin(value)
            else:
                full[joint.idx_q] = value
        pin.computeJointJacobians(self.model, self.data, full)
        pin.updateFramePlacements(self.model, self.data)
        self.q = full

    def frame(self, name: str) -> tuple[pin.SE3, np.ndarray]:
        """Return a link's placement in the world and its Jacobian (6, n) where q is set."""
        index = self.model.getFrameId(name, pin.BODY)
        jacobian = pin.getFrameJacobian(
            self.model, self.data, index, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        )
        turn = np.kron(np.eye(2), self.place.rotation)
        return self.place * self.data.oMf[index], turn @ jacobian @ self.map

    def mass(self) -> np.ndarray:
        """Return the mass matrix of the robot's joints, shape (n, n), with its armatures."""
        mass = np.triu(pin.crba(self.model, self.data, self.q))
        mass = mass + np.triu(mass, 1).T
        added = np.zeros(self.robot.n)
        added[self.robot.arm] = self.robot.config.arm.armature
        return self.map.T @ mass @ self.map + np.diag(added)
