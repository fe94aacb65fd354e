.PHONY: run test check library api database tokens postgres faketime programs bench tolerance fuzz lint tools fmt openapi types files interop contract deploy operators image wheel dist python typescript csharp cpp freecad conformance browser chromium node viewer page paint turn pictures

# Python packages that read the exported files, talk gRPC and test the client.
VENV := target/venv
PYTHON := $(VENV)/bin/python

# The TypeScript client, and what finds a Node for it.
TYPESCRIPT := clients/typescript
VIEWER := viewer
WITH_NODE := PATH="$(CURDIR)/target/node/node_modules/node/bin:$$PATH"
NODE_IS_NEW := process.exit(process.versions.node.split(".")[0] < 20 ? 1 : 0)

# Serves on 127.0.0.1:8080.
run:
	cargo run --release

# What fetches something is tried three times.
RETRY := $(CURDIR)/tests/retry
INSTALL := $(CURDIR)/tests/install

# Everything that a change must pass; installs what that needs. Of two clients at a time one at most installs something.
test:
	@tests/steps tools lint library api programs files interop contract deploy browser node "python csharp" "typescript cpp" "conformance freecad" page

# What to run while working: a few minutes after a small change.
check:
	@tests/steps tools lint library api

# Unit tests, the examples of the documentation, and a program that uses the crates.
library: tools postgres
	tests/postgres cargo nextest run --locked --workspace --lib --bins
	cargo test --locked --workspace --doc
	tests/outside

# A server, by its API; what concerns jobs themselves with them in a database, too.
OF_JOBS := jobs|streams|durable|deleting|edits|ephemeral|milestones|views|peers|quotas|crashes
api: tools postgres faketime
	tests/postgres cargo nextest run --locked --test api
	PIAD_TEST_STORE=database tests/postgres cargo nextest run --locked --test api -E 'test(/^($(OF_JOBS))::/) - test(/^($(OF_A_FILE))/)'

# All of it with jobs in a database, without the tests of what one process does with its file: there a job
# that was running in a crash waits for the end of a lease.
OF_A_FILE := damage::|salvage::|crash_recovery::|durable::(a_commit|only_one|a_server_waits|unknown_files|a_full_disk|jobs_can_be|a_job_that_was)
database: tools postgres
	PIAD_TEST_STORE=database tests/postgres cargo nextest run --locked --test api -E 'not test(/^($(OF_A_FILE))/)'

# The API with tokens: all clients have one, and nothing that servers tell has. Not those that speak byte by byte, those
# about addresses of clients, whose place tenants take, and those with tokens of their own.
WITHOUT_TOKENS := access[a-z_]*|attacks|base_path|bodies|crowd|doors|floods|heads|made_up|peers|proxies|readme|secure
tokens: tools postgres
	PIAD_TOKEN=piad_$$(printf 'A%.0s' $$(seq 43)) tests/postgres cargo nextest run --locked --test api -E 'not test(/^($(WITHOUT_TOKENS))::/)'

# `piad fit`, and the files that `make files` reads.
programs: tools
	cargo nextest run --locked --test architecture --test command --test export

# Exported files, read by OpenCASCADE, OpenNURBS and others; offset, thickened and joined by OpenCASCADE.
files: $(VENV)/installed
	$(PYTHON) tests/python/export_check.py --all target/tmp/export
	$(PYTHON) tests/python/over_http.py target/debug/piad
	$(PYTHON) tests/python/command.py target/debug/piad
	$(PYTHON) tests/python/parts.py target/debug/piad
	$(PYTHON) tests/python/units.py target/debug/piad
	$(PYTHON) tests/python/offsets.py target/debug/piad
	$(PYTHON) tests/python/joins.py target/debug/piad
	$(PYTHON) tests/python/trims.py target/debug/piad
	$(PYTHON) tests/python/outlines.py target/debug/piad
	$(PYTHON) tests/python/scans.py target/debug/piad

# A gRPC client in another language, from the contract alone.
interop: $(VENV)/installed
	$(PYTHON) tests/python/grpc_client.py target/debug/piad

# A page of another origin in a browser; TLS with clients of all kinds.
browser: $(VENV)/installed chromium
	$(PYTHON) tests/python/cors_check.py target/debug/piad
	$(PYTHON) tests/python/handshakes.py target/debug/piad

# The API against its own description: what it answers, and requests that schemathesis makes up.
contract: $(VENV)/installed
	$(PYTHON) tests/python/description.py target/debug/piad
	$(PYTHON) tests/python/contract.py target/debug/piad

# What deploy/ has, read by the programs that it is for; and a server behind the proxies of docs/OPERATIONS.md.
deploy: $(VENV)/installed postgres operators
	tests/postgres $(PYTHON) tests/python/deploy.py target/debug/piad
	$(PYTHON) tests/python/proxies.py target/debug/piad

# promtool, Compose and proxies. Debian also starts servers of nginx, Caddy and Prometheus, which nothing here needs.
operators:
	@command -v promtool >/dev/null && command -v docker-compose >/dev/null && command -v caddy >/dev/null && \
	  command -v openssl >/dev/null && test -x /usr/sbin/nginx || \
	  $(INSTALL) prometheus docker-compose caddy openssl nginx-light

# The image of the Dockerfile, built by buildah and tried: ten minutes the first time.
image:
	@command -v buildah >/dev/null && command -v podman >/dev/null && command -v debootstrap >/dev/null && \
	  command -v objcopy >/dev/null || \
	  $(INSTALL) buildah podman crun debootstrap binutils python3
	deploy/image
	python3 tests/python/image.py

# The profile of the packages; PROFILE=dev is quicker to build.
PROFILE := release

# The client of Python and the program in one wheel, in target/wheel.
wheel:
	@python3 -m venv target/wheel/venv || $(INSTALL) python3-venv
	python3 -m venv target/wheel/venv
	cargo build --locked --profile $(PROFILE) --bin piad
	PYTHON=target/wheel/venv/bin/python clients/python/wheel target/$(PROFILE:dev=debug)/piad

# A static program with completions and manual pages in an archive, in target/dist; tried in an empty root.
dist:
	archive=$$(PROFILE=$(PROFILE) deploy/dist) && \
	  python3 tests/python/dist.py "$$archive" "$$(git rev-parse --short=12 HEAD)"

# Writes docs/openapi.json, which tests compare with what a server says.
openapi:
	PIAD_WRITE_OPENAPI=1 cargo test --locked --test api the_file_is_what_a_server_says

# The Python client against real servers, and what files of the clients and of the page import.
python: $(VENV)/installed
	@command -v openssl >/dev/null || $(INSTALL) openssl
	$(PYTHON) tests/python/imports.py
	$(PYTHON) -m mypy --cache-dir target/mypy --config-file clients/python/pyproject.toml clients/python/src
	cd clients/python && PIAD_PROGRAM=$(CURDIR)/target/debug/piad $(CURDIR)/$(PYTHON) -m pytest -q -p no:cacheprovider

# The TypeScript client against real servers, in Node and in Chromium. Its types are those of the description.
typescript: chromium node $(TYPESCRIPT)/node_modules/.package-lock.json
	cd $(TYPESCRIPT) && $(WITH_NODE) PIAD_PROGRAM=$(CURDIR)/target/debug/piad npm test --silent

# The C# client against real servers, under Mono, which it installs from Debian where it is missing.
csharp:
	PIAD_PROGRAM=$(CURDIR)/target/debug/piad clients/csharp/run

# The C++ client against real servers, with OpenCASCADE and gRPC, which it installs from Debian where they are missing.
cpp:
	PIAD_PROGRAM=$(CURDIR)/target/debug/piad clients/cpp/run

# The workbench in FreeCAD, which it installs from Debian where it is missing.
freecad:
	PIAD_PROGRAM=$(CURDIR)/target/debug/piad clients/freecad/run

# All clients in the same scenarios, with the numbers of the server to the bit.
conformance: $(VENV)/installed node $(TYPESCRIPT)/node_modules/.package-lock.json
	clients/csharp/run build
	clients/cpp/run build
	cd $(TYPESCRIPT) && $(WITH_NODE) npm run --silent pretest
	$(PYTHON) tests/conformance/run.py target/debug/piad

$(TYPESCRIPT)/node_modules/.package-lock.json: $(TYPESCRIPT)/package-lock.json | node
	cd $(TYPESCRIPT) && $(WITH_NODE) $(RETRY) npm ci --silent
	touch $@

# Types for it, from docs/openapi.json.
types: $(TYPESCRIPT)/node_modules/.package-lock.json
	cd $(TYPESCRIPT) && $(WITH_NODE) npm run --silent generate

# The page, from viewer/src to viewer/dist, which the program contains.
viewer: $(VIEWER)/node_modules/.package-lock.json
	cd $(VIEWER) && $(WITH_NODE) npm run --silent check && $(WITH_NODE) npm run --silent build

# The page in Chromium, with real servers. It fails if viewer/dist is not made from viewer/src as it is.
page: chromium node $(VIEWER)/node_modules/.package-lock.json
	cd $(VIEWER) && $(WITH_NODE) PIAD_PROGRAM=$(CURDIR)/target/debug/piad npm test --silent

# The pictures of the README, docs/pictures: the page in Chromium with a server of its own, light and dark.
pictures: chromium node $(VIEWER)/node_modules/.package-lock.json
	cargo build --locked
	cd $(VIEWER) && $(WITH_NODE) PIAD_PROGRAM=$(CURDIR)/target/debug/piad npm run --silent pictures

# How long it takes until a fit is seen, and how fluently large ones turn, in Chromium on this machine.
paint turn: chromium node $(VIEWER)/node_modules/.package-lock.json
	cargo build --release --locked
	cd $(VIEWER) && $(WITH_NODE) PIAD_PROGRAM=$(CURDIR)/target/release/piad npm run --silent $@

$(VIEWER)/node_modules/.package-lock.json: $(VIEWER)/package-lock.json | node
	cd $(VIEWER) && $(WITH_NODE) $(RETRY) npm ci --silent
	touch $@

# Node 20 or later and npm: of the system, or a Node of the registry where that of the system is older.
node:
	@command -v npm >/dev/null || $(INSTALL) nodejs npm
	@$(WITH_NODE) node -e '$(NODE_IS_NEW)' || $(RETRY) npm install --silent --no-save --prefix target/node node@22
	@$(WITH_NODE) node -e '$(NODE_IS_NEW)' || \
	  { echo "clients/typescript needs Node 20 or later, and this is $$(node --version): https://nodejs.org" >&2; exit 1; }

chromium:
	@command -v chromium >/dev/null && command -v chromedriver >/dev/null && command -v openssl >/dev/null && \
	  command -v curl >/dev/null || $(INSTALL) chromium chromium-driver openssl curl

# Kernels, HTTP and other programs, measured side by side: about a quarter of an hour on a quiet machine.
bench: $(VENV)/benches
	cargo bench --locked --bench kernels
	$(PYTHON) benches/http/compare.py target/release/piad
	$(PYTHON) benches/http/neighbours.py target/release/piad
	$(PYTHON) benches/http/bodies.py target/release/piad
	$(PYTHON) benches/http/deltas.py target/release/piad
	$(PYTHON) benches/batch/compare.py target/release/piad
	$(PYTHON) benches/files/reading.py target/release/piad
	$(PYTHON) benches/files/memory.py target/release/piad
	$(PYTHON) benches/scipy/compare.py target/release/piad

# As few control points as a tolerance needs, beside scipy, OpenCASCADE and geomdl: three quarters of an hour.
tolerance: $(VENV)/tolerance
	cargo build --locked --release
	$(PYTHON) benches/tolerance/compare.py target/release/piad
	$(PYTHON) benches/tolerance/memory.py target/release/piad
	$(PYTHON) benches/sections/compare.py target/release/piad
	$(PYTHON) benches/scans/compare.py target/release/piad

$(VENV)/tolerance: benches/tolerance/requirements.txt
	@python3 -m venv $(VENV) && ldconfig -p | grep -q libGL.so.1 || \
	  $(INSTALL) python3-venv libgl1
	python3 -m venv $(VENV)
	$(RETRY) $(PYTHON) -m pip install --quiet -r $<
	touch $@

$(VENV)/benches: benches/requirements.txt
	@python3 -m venv $(VENV) && command -v wrk >/dev/null || \
	  $(INSTALL) python3-venv wrk
	python3 -m venv $(VENV)
	$(RETRY) $(PYTHON) -m pip install --quiet -r benches/requirements.txt
	touch $@

# Each decoder with bytes that nobody would send, for ten minutes; needs a nightly toolchain and
# `cargo install cargo-fuzz`. What a target finds is in fuzz/artifacts.
FUZZ_SECONDS := 600
fuzz: $(patsubst %,fuzz-%,job edit message edit_message record made file requests)

# Requests that schemathesis makes up, others each time.
fuzz-requests: $(VENV)/installed
	cargo build --locked
	$(PYTHON) tests/python/contract.py target/debug/piad --max-examples 10000 --max-time $(FUZZ_SECONDS) --seed $$(date +%s)

fuzz-%:
	mkdir -p fuzz/corpus/$*
	PIAD_WRITE_SEEDS=1 cargo test --locked --lib fuzzing
	cargo +nightly fuzz run $* fuzz/corpus/$* $(wildcard fuzz/seeds/$*) -- \
	  $(if $(wildcard fuzz/seeds/$*),-dict=$(or $(wildcard fuzz/$*.dict),fuzz/json.dict)) -max_total_time=$(FUZZ_SECONDS) \
	  -max_len=4096 -timeout=5 -rss_limit_mb=1024 -malloc_limit_mb=64 -print_final_stats=1

# Files of one format after another, each from its own seed.
fuzz-files:
	for seed in fuzz/seeds/file/*; do \
	  mkdir -p fuzz/corpus/$$(basename $$seed) && cp $$seed fuzz/corpus/$$(basename $$seed)/ && \
	  cargo +nightly fuzz run file fuzz/corpus/$$(basename $$seed) -- -dict=fuzz/file.dict -max_total_time=$(FUZZ_SECONDS) \
	    -max_len=4096 -timeout=5 -rss_limit_mb=1024 -malloc_limit_mb=64 -print_final_stats=1 || exit 1; \
	done

# Also that the documentation of the crates has no broken links, that they can be packaged, and that the documents are
# readable.
lint: tools
	@command -v python3 >/dev/null || $(INSTALL) python3
	python3 tests/python/prose.py
	cargo fmt --all --check
	cargo clippy --locked --workspace --all-targets -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --locked --workspace --lib --no-deps
	cargo package --locked --workspace --no-verify --quiet

fmt:
	cargo fmt --all

# PostgreSQL, of which tests/postgres starts clusters of its own.
postgres:
	@ls /usr/lib/postgresql/*/bin/initdb >/dev/null 2>&1 && command -v setpriv psql >/dev/null || \
	  $(INSTALL) postgresql util-linux

# Sets the clock of a server.
faketime:
	@ls /usr/lib/*/faketime/libfaketimeMT.so.1 >/dev/null 2>&1 || $(INSTALL) faketime

# A linker and kill(1) from the system, the formatter and the linter of the toolchain, the runner of tests.
tools:
	@command -v cc >/dev/null && command -v kill >/dev/null || \
	  $(INSTALL) gcc libc6-dev procps
	@cargo fmt --version >/dev/null 2>&1 && cargo clippy --version >/dev/null 2>&1 || \
	  $(RETRY) rustup component add rustfmt clippy
	@cargo nextest --version >/dev/null 2>&1 || $(RETRY) cargo install --locked cargo-nextest@0.9.143

# cairosvg needs the cairo library, and OpenCASCADE an OpenGL library, of the system.
REQUIREMENTS := tests/python/requirements.txt clients/python/tests/requirements.txt
$(VENV)/installed: $(REQUIREMENTS) clients/python/pyproject.toml
	@python3 -m venv $(VENV) && ldconfig -p | grep -q libcairo.so.2 && ldconfig -p | grep -q libGL.so.1 || \
	  $(INSTALL) python3-venv libcairo2 libgl1
	python3 -m venv $(VENV)
	$(RETRY) $(PYTHON) -m pip install --quiet $(REQUIREMENTS:%=-r %) -e clients/python
	touch $@
