.PHONY: run test interop lint tools fmt

# Serves on 127.0.0.1:8080.
run:
	cargo run --release

# Everything that a change must pass; installs what that needs.
test: tools lint
	cargo test --locked

# A client in another language, from the contract alone; needs Python 3 with venv.
interop:
	cargo build --locked
	@test -d target/python || python3 -m venv target/python
	target/python/bin/pip install --quiet -r tests/python/requirements.txt
	target/python/bin/python tests/python/grpc_client.py target/debug/piad

lint: tools
	cargo fmt --check
	cargo clippy --locked --all-targets -- -D warnings

fmt:
	cargo fmt

# A linker and kill(1) from the system, the formatter and the linter of the toolchain.
tools:
	@command -v cc >/dev/null && command -v kill >/dev/null || \
	  { apt-get update && apt-get install -y --no-install-recommends gcc libc6-dev procps; }
	@cargo fmt --version >/dev/null 2>&1 && cargo clippy --version >/dev/null 2>&1 || \
	  rustup component add rustfmt clippy
