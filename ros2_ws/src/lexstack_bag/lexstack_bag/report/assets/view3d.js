"use strict";
// The robots in three dimensions: a scene for three.js made from plain data, moved by q.
// Lengths in metres, quaternions x, y, z, w, the world frame with z up.
const View3d = (() => {
  const AXIS_COLORS = [0xc0392b, 0x1e8449, 0x1f4e9c];

  function meshGeometry(mesh) {
    const places = new Uint16Array(decoded(mesh.vertices));
    const vertices = new Float32Array(places.length);
    places.forEach((place, i) => { vertices[i] = mesh.lower[i % 3] + mesh.step[i % 3] * place; });
    const Indices = mesh.wide ? Uint32Array : Uint16Array;
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(vertices, 3));
    geometry.setIndex(new THREE.BufferAttribute(new Indices(decoded(mesh.faces)), 1));
    geometry.computeVertexNormals();
    return geometry;
  }

  function partGeometry(part, meshes) {
    const [a, b, c] = part.size || [];
    switch (part.kind) {
      case "box": return new THREE.BoxGeometry(2 * a, 2 * b, 2 * c);
      case "sphere": return new THREE.SphereGeometry(a, 20, 14);
      case "cylinder": return new THREE.CylinderGeometry(a, a, 2 * b, 24).rotateX(Math.PI / 2);
      case "capsule": return new THREE.CapsuleGeometry(a, 2 * b, 3, 8).rotateX(Math.PI / 2);
      default: return meshes[part.mesh];
    }
  }

  function place(object, pose) {
    object.position.fromArray(pose.position);
    object.quaternion.fromArray(pose.quaternion);
    return object;
  }

  function material(color) {
    const [red, green, blue, alpha] = color;
    return new THREE.MeshStandardMaterial({
      color: new THREE.Color(red, green, blue).convertSRGBToLinear(), roughness: 0.65, metalness: 0.05,
      transparent: alpha < 1, opacity: alpha,
    });
  }

  function frame(length) {
    const group = new THREE.Group();
    AXIS_COLORS.forEach((color, i) => {
      const direction = new THREE.Vector3().setComponent(i, 1);
      group.add(new THREE.ArrowHelper(direction, undefined, length, color, 0.25 * length,
        0.12 * length));
    });
    return group;
  }

  class View {
    // element: where to draw; scene: robots, bodies, meshes (lexstack_sim/scene.py).
    constructor(element, scene) {
      this.element = element;
      this.renderer = new THREE.WebGLRenderer({ antialias: true });
      this.renderer.outputEncoding = THREE.sRGBEncoding;
      this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
      element.append(this.renderer.domElement);
      this.world = new THREE.Scene();
      this.world.background = new THREE.Color(0xeef1f4);
      this.camera = new THREE.PerspectiveCamera(34, 1, 0.05, 200);
      this.camera.up.set(0, 0, 1);
      this.joints = [];
      this.targets = [];
      this.balls = [];
      this.drawn = 0;
      this._light();
      this._build(scene);
      this._control();
      new ResizeObserver(() => this._resize()).observe(element);
      this._resize();
      const loop = () => { this._tick(); requestAnimationFrame(loop); };
      loop();
    }

    // state: q of all robots; ee: 7 numbers a robot; base: x, y, yaw; obstacles: centers, flat.
    set(state) {
      for (const joint of this.joints) {
        const value = joint.ratio * state.q[joint.index] + joint.offset;
        if (joint.slides) joint.node.position.copy(joint.axis).multiplyScalar(value);
        else joint.node.quaternion.setFromAxisAngle(joint.axis, value);
      }
      (state.ee || []).forEach((pose, i) => {
        const node = this._target(this.targets, i, () => frame(0.16));
        node.position.set(pose[0], pose[1], pose[2]);
        node.quaternion.set(pose[3], pose[4], pose[5], pose[6]);
      });
      this.balls.forEach((ball, i) => ball.position.fromArray(state.obstacles, 3 * i));
      this.dirty = true;
    }

    // Adds the line through points (x, y, z, flat) in a colour.
    path(points, color) {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.BufferAttribute(points, 3));
      const line = new THREE.Line(geometry, new THREE.LineBasicMaterial({ color }));
      this.world.add(line);
      this.dirty = true;
      return line;
    }

    // Adds spheres that set() moves: radii in metres.
    obstacles(radii) {
      for (const radius of radii) {
        const ball = new THREE.Mesh(new THREE.SphereGeometry(radius, 32, 20),
          material([0.8, 0.47, 0.65, 0.8]));
        this.balls.push(ball);
        this.world.add(ball);
      }
    }

    // Looks from the front right so that a box of the world is in view.
    look(lower, upper) {
      const box = new THREE.Box3(new THREE.Vector3(...lower), new THREE.Vector3(...upper));
      const ball = box.getBoundingSphere(new THREE.Sphere());
      const aspect = Math.min(1, this.camera.aspect);
      const distance = 0.7 * ball.radius / Math.sin(0.5 * aspect * this.camera.fov * Math.PI / 180);
      this.controls.target.copy(ball.center);
      this.camera.position.set(-0.38, -0.82, 0.44).normalize().multiplyScalar(distance)
        .add(ball.center);
      this.camera.lookAt(ball.center);
      this.dirty = true;
    }

    // Where a point of the world is on the page: x, y in CSS pixels of the element.
    project(point) {
      this.camera.updateMatrixWorld();
      const seen = new THREE.Vector3(...point).project(this.camera);
      const { clientWidth: width, clientHeight: height } = this.element;
      return [0.5 * width * (1 + seen.x), 0.5 * height * (1 - seen.y)];
    }

    _target(list, i, make) {
      if (!list[i]) {
        list[i] = make();
        this.world.add(list[i]);
      }
      return list[i];
    }

    _light() {
      this.world.add(new THREE.HemisphereLight(0xffffff, 0x8d99a6, 0.75));
      for (const [x, y, z, strength] of [[-3, -5, 8, 0.65], [5, 3, 5, 0.25]]) {
        const light = new THREE.DirectionalLight(0xffffff, strength);
        light.position.set(x, y, z);
        this.world.add(light);
      }
      const grid = new THREE.GridHelper(20, 20, 0x8d99a6, 0xc6cdd5).rotateX(Math.PI / 2);
      this.world.add(grid, new THREE.AxesHelper(0.4));
    }

    _build(scene) {
      const meshes = scene.meshes.map(meshGeometry);
      const nodes = [];
      for (const body of scene.bodies) {
        let node = place(new THREE.Group(), body);
        (nodes[body.parent] || this.world).add(node);
        for (const joint of body.joints) {
          const moved = new THREE.Group();
          node.add(moved);
          this.joints.push({ ...joint, node: moved, axis: new THREE.Vector3(...joint.axis) });
          node = moved;
        }
        nodes.push(node);
        for (const part of body.parts) {
          node.add(place(new THREE.Mesh(partGeometry(part, meshes), material(part.color)), part));
        }
      }
    }

    _control() {
      const canvas = this.renderer.domElement;
      this.controls = new THREE.TrackballControls(this.camera, canvas);
      Object.assign(this.controls, { staticMoving: true, rotateSpeed: 2.5, noZoom: true });
      this.controls.keys = [];
      this.controls.addEventListener("change", () => { this.dirty = true; });
      // The wheel scrolls the page until the view has been clicked.
      canvas.addEventListener("pointerdown", () => { this.controls.noZoom = false; });
      canvas.addEventListener("pointerleave", () => { this.controls.noZoom = true; });
    }

    _resize() {
      const { clientWidth: width, clientHeight: height } = this.element;
      if (!width || !height) return;
      this.renderer.setSize(width, height);
      this.camera.aspect = width / height;
      this.camera.updateProjectionMatrix();
      this.controls.handleResize();
      this.dirty = true;
    }

    _tick() {
      this.camera.up.set(0, 0, 1); // the horizon stays level
      this.controls.update();
      if (!this.dirty) return;
      this.dirty = false;
      this.renderer.render(this.world, this.camera);
      this.drawn += 1;
    }
  }

  // Returns a view, or nothing where the browser cannot draw; the element then says so.
  function open(element, scene) {
    try {
      return new View(element, scene);
    } catch (error) {
      element.classList.add("note");
      element.textContent = `No 3-D view: ${error.message}`;
      return undefined;
    }
  }

  return { open };
})();
