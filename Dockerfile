# docker build -t lexstack .
# docker run --rm lexstack                    the demo
# docker run --rm lexstack ./scripts/test     the tests
FROM debian:bookworm-slim

WORKDIR /lexstack

# The slow part first, from few files, so that a change of the code keeps it.
COPY . .
RUN ./scripts/setup && rm -rf /var/lib/apt/lists/* /root/.cache

CMD ["./scripts/demo"]
