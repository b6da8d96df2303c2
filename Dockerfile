# docker build -t lexstack .
# docker run --rm -v "$PWD/runs:/lexstack/runs" lexstack    the demo, its run folder kept
# docker run --rm lexstack ./scripts/test                   the tests
FROM debian:bookworm-slim

WORKDIR /lexstack
COPY . .
RUN PIP_NO_CACHE_DIR=1 ./scripts/setup && rm -rf /var/lib/apt/lists/*

CMD ["./scripts/demo"]
