# docker build -t lexstack .
# docker run --rm -v "$PWD/runs:/lexstack/runs" lexstack    the demo, its run folder kept
# docker run --rm lexstack ./scripts/test                   the tests
# The folder that is mounted must be writable for user 1000.
FROM debian:bookworm-slim

RUN useradd --create-home --uid 1000 lexstack
WORKDIR /lexstack
COPY . .
RUN PIP_NO_CACHE_DIR=1 ./scripts/setup && rm -rf /var/lib/apt/lists/* \
    && mkdir -p runs && chown -R lexstack /lexstack

# The set-up needs root for apt; nothing else does.
USER lexstack
CMD ["./scripts/demo"]
