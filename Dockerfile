# scanrack and its page. Build and run:
#
#     docker build -t scanrack .
#     docker run --rm -p 127.0.0.1:8765:8765 -v "$PWD:/work" scanrack watch line.toml --port 8765
#
# The page listens on the loopback of the container only; `forward` carries its port out. The link it prints holds
# a key: who does not have it sees nothing.
FROM python:3.13-slim AS build
WORKDIR /source
COPY . .
RUN pip wheel --no-cache-dir --no-deps --wheel-dir /wheels .

FROM python:3.13-slim
RUN apt-get update && apt-get install -y --no-install-recommends socat tini && rm -rf /var/lib/apt/lists/*
COPY --from=build /wheels /wheels
RUN pip install --no-cache-dir /wheels/*.whl && rm -r /wheels && useradd --uid 1000 --create-home plc
COPY docker/forward /usr/local/bin/forward
USER plc
WORKDIR /work
EXPOSE 8765
ENTRYPOINT ["tini", "--", "forward", "8765", "scanrack"]
CMD ["--help"]
