# docker build -t lexstack .
# mkdir -p runs
# docker run --rm --user "$(id -u):$(id -g)" -v "$PWD/runs:/lexstack/runs" lexstack
#                                            the demo; its run folder is kept, and yours
# docker run --rm lexstack ./scripts/test    the tests
FROM debian:bookworm-slim

# What the set-up would install as root, and what only the tests need: Chromium looks at the pages,
# ip makes virtual hosts (where the container may: docker run --privileged --user root).
RUN apt-get update && apt-get install -y --no-install-recommends \
        python3 python3-venv python3-dev g++ cmake make libegl1 libgl1-mesa-dri libgl1 \
        chromium iproute2 \
    && rm -rf /var/lib/apt/lists/* \
    && useradd --create-home --uid 1000 lexstack \
    && install -d -o lexstack -g lexstack /lexstack
USER lexstack
WORKDIR /lexstack

# The packages have a layer of their own, which only their list and the set-up make anew.
COPY --chown=lexstack requirements.lock ./
COPY --chown=lexstack scripts/setup scripts/setup_workspace.py scripts/
COPY --chown=lexstack scripts/workspace scripts/workspace
RUN PIP_NO_CACHE_DIR=1 ./scripts/setup --packages

# Runs may be written by any account: docker run --user.
COPY --chown=lexstack . .
RUN ./scripts/setup && mkdir -p -m 1777 runs
CMD ["./scripts/demo"]
