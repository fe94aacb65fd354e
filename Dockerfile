# A static binary in an image with only CA certificates.
#
#   docker build -t piad --build-arg PIAD_COMMIT="$(git rev-parse --short=12 HEAD)" .
#   docker run --rm -p 127.0.0.1:8080:8080 -e PIAD_INSECURE_NO_AUTH=true -v piad-data:/data piad
#   docker run --rm -u "$(id -u)" -v "$PWD:/work" -w /work piad fit wing.dat -o wing.step
#
# `make image` builds it with buildah and tests it.

ARG RUST=docker.io/library/rust:1-slim-bookworm

FROM ${RUST} AS build
WORKDIR /build
# Writes the list of crates into the binary, where scanners look for it.
RUN --mount=type=cache,target=/usr/local/cargo/registry \
    cargo install --locked --root /usr/local cargo-auditable@0.7.7
COPY Cargo.toml Cargo.lock build.rs ./
COPY proto ./proto
COPY crates ./crates
COPY src ./src
COPY benches ./benches
COPY viewer/dist ./viewer/dist
# The commit for `piad --version`: there is no repository in here.
ARG PIAD_COMMIT=""
# A static binary cannot look up getrandom by name: it calls the kernel instead of opening
# /dev/urandom. Relative relocations in their short form make it half a megabyte smaller.
ENV RUSTFLAGS="-C target-feature=+crt-static -C link-arg=-Wl,-z,pack-relative-relocs --cfg getrandom_backend=\"linux_getrandom\""
# The caches keep compiled dependencies, so a change in src compiles only piad.
RUN --mount=type=cache,target=/usr/local/cargo/registry --mount=type=cache,target=/build/target \
    target="$(uname -m)-unknown-linux-gnu" \
 && cargo auditable build --release --locked --target "$target" \
 && cp "target/$target/release/piad" /piad \
 && mkdir /data

FROM scratch
ARG PIAD_COMMIT=""
ARG PIAD_VERSION=""
LABEL org.opencontainers.image.title="piad" \
      org.opencontainers.image.description="Fits curves and surfaces, and streams every iteration" \
      org.opencontainers.image.version="${PIAD_VERSION}" \
      org.opencontainers.image.revision="${PIAD_COMMIT}" \
      org.opencontainers.image.licenses="MIT OR Apache-2.0"
COPY --from=build /piad /piad
# CA certificates for `piad fit --server https://…`.
COPY --from=build /etc/ssl/certs/ca-certificates.crt /etc/ssl/certs/ca-certificates.crt
COPY --from=build --chown=65532:65532 /data /data
USER 65532:65532
ENV PIAD_LISTEN=0.0.0.0:8080 PIAD_STORE=/data
VOLUME /data
EXPOSE 8080
STOPSIGNAL SIGTERM
HEALTHCHECK --interval=10s --timeout=5s --start-period=2s CMD ["/piad", "health"]
ENTRYPOINT ["/piad"]
