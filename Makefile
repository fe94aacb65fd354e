.PHONY: run test bench fuzz lint tools fmt openapi files interop contract python browser

# Python packages that read the exported files, talk gRPC and test the client.
VENV := target/venv
PYTHON := $(VENV)/bin/python

# Serves on 127.0.0.1:8080.
run:
	cargo run --release

# Everything that a change must pass; installs what that needs.
test: tools lint
	cargo test --locked
	$(MAKE) files interop contract python browser

# Exported files, read by OpenCASCADE, OpenNURBS and others; offset, thickened and joined by OpenCASCADE.
files: $(VENV)/installed
	$(PYTHON) tests/python/export_check.py --all target/tmp/export
	$(PYTHON) tests/python/over_http.py target/debug/piad
	$(PYTHON) tests/python/offsets.py target/debug/piad
	$(PYTHON) tests/python/joins.py target/debug/piad

# A gRPC client in another language, from the contract alone.
interop: $(VENV)/installed
	$(PYTHON) tests/python/grpc_client.py target/debug/piad

# A page of another origin in a browser.
browser: $(VENV)/installed
	@command -v chromium >/dev/null && command -v chromedriver >/dev/null || \
	  { apt-get update && apt-get install -y --no-install-recommends chromium chromium-driver; }
	$(PYTHON) tests/python/cors_check.py target/debug/piad

# The API against its own description: what it answers, and requests that schemathesis makes up.
contract: $(VENV)/installed
	$(PYTHON) tests/python/description.py target/debug/piad
	$(PYTHON) tests/python/contract.py target/debug/piad

# Writes docs/openapi.json, which tests compare with what a server says.
openapi:
	PIAD_WRITE_OPENAPI=1 cargo test --locked --test api the_file_is_what_a_server_says

# The Python client against real servers.
python: $(VENV)/installed
	$(PYTHON) -m mypy --cache-dir target/mypy --config-file clients/python/pyproject.toml clients/python/src
	cd clients/python && PIAD_PROGRAM=$(CURDIR)/target/debug/piad $(CURDIR)/$(PYTHON) -m pytest -q -p no:cacheprovider

# Kernels, HTTP and other programs, measured side by side: about ten minutes on a quiet machine.
bench: $(VENV)/benches
	cargo bench --locked --bench kernels
	$(PYTHON) benches/http/compare.py target/release/piad
	$(PYTHON) benches/scipy/compare.py target/release/piad

$(VENV)/benches: benches/requirements.txt
	@python3 -m venv $(VENV) && command -v wrk >/dev/null || \
	  { apt-get update && apt-get install -y --no-install-recommends python3-venv wrk; }
	python3 -m venv $(VENV)
	$(PYTHON) -m pip install --quiet -r benches/requirements.txt
	touch $@

# Each decoder with bytes that nobody would send, for ten minutes; needs a nightly toolchain and
# `cargo install cargo-fuzz`. What a target finds is in fuzz/artifacts.
FUZZ_SECONDS := 600
fuzz: $(patsubst %,fuzz-%,job edit message edit_message record made)

fuzz-%:
	mkdir -p fuzz/corpus/$*
	PIAD_WRITE_SEEDS=1 cargo test --locked --lib fuzzing
	cargo +nightly fuzz run $* fuzz/corpus/$* $(wildcard fuzz/seeds/$*) -- \
	  $(if $(wildcard fuzz/seeds/$*),-dict=fuzz/json.dict) -max_total_time=$(FUZZ_SECONDS) \
	  -max_len=4096 -timeout=5 -rss_limit_mb=1024 -malloc_limit_mb=64 -print_final_stats=1

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

# cairosvg needs the cairo library, and OpenCASCADE an OpenGL library, of the system.
REQUIREMENTS := tests/python/requirements.txt clients/python/tests/requirements.txt
$(VENV)/installed: $(REQUIREMENTS) clients/python/pyproject.toml
	@python3 -m venv $(VENV) && ldconfig -p | grep -q libcairo.so.2 && ldconfig -p | grep -q libGL.so.1 || \
	  { apt-get update && apt-get install -y --no-install-recommends python3-venv libcairo2 libgl1; }
	python3 -m venv $(VENV)
	$(PYTHON) -m pip install --quiet $(REQUIREMENTS:%=-r %) -e clients/python
	touch $@
