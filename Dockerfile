# A static binary in an image that has nothing else but the certificates of authorities.
#
#   docker build -t piad --build-arg PIAD_COMMIT="$(git rev-parse --short=12 HEAD)" .
#   docker run --rm -p 8080:8080 -v piad-data:/data piad
#   docker run --rm -u "$(id -u)" -v "$PWD:/work" -w /work piad fit wing.dat -o wing.step

FROM rust:1-slim-bookworm AS build
WORKDIR /build
COPY Cargo.toml Cargo.lock build.rs ./
COPY proto ./proto
COPY src ./src
COPY viewer/dist ./viewer/dist
# What `piad --version` tells beside the version: there is no repository in here.
ARG PIAD_COMMIT=""
# A static binary cannot look getrandom up by name: it calls the kernel rather than open /dev/urandom.
ENV RUSTFLAGS="-C target-feature=+crt-static --cfg getrandom_backend=\"linux_getrandom\""
RUN target="$(uname -m)-unknown-linux-gnu" \
 && cargo build --release --locked --target "$target" \
 && cp "target/$target/release/piad" /piad \
 && mkdir /data

FROM scratch
COPY --from=build /piad /piad
# Whom `piad fit --server https://…` trusts.
COPY --from=build /etc/ssl/certs/ca-certificates.crt /etc/ssl/certs/ca-certificates.crt
COPY --from=build --chown=65532:65532 /data /data
USER 65532:65532
ENV PIAD_LISTEN=0.0.0.0:8080 PIAD_STORE=/data
VOLUME /data
EXPOSE 8080
STOPSIGNAL SIGTERM
HEALTHCHECK --interval=10s --timeout=5s --start-period=2s CMD ["/piad", "health"]
ENTRYPOINT ["/piad"]
