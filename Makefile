# In front of CMake, for people who want one word. Each target installs what it needs and builds
# first (scripts/setup.sh).

BUILD = build/release
GNOMON = $(BUILD)/bin/gnomon
PREFIX = /usr/local

.PHONY: help build demo report test bench figures format clean install

help:
	@echo "make demo      render the built-in scene with every method: out/demo/index.html"
	@echo "make report    the methods on the built-in scenes, with the papers' figures and tables, in ten"
	@echo "               minutes: out/report/index.html"
	@echo "make test      build and run the tests"
	@echo "make bench     the tables of docs/benchmarks.md: times, flicker and errors of the methods on"
	@echo "               built-in scenes, and on those of the folder GNOMON_SCENES, if set"
	@echo "make figures   every picture and plot of README and docs"
	@echo "make build     build into $(BUILD); the program is $(GNOMON)"
	@echo "make install   install into PREFIX, $(PREFIX)"
	@echo "make format    bring all C files into the project's style (clang-format)"
	@echo "make clean     remove build/ and out/"

build:
	@scripts/setup.sh build
	@[ -f $(BUILD)/build.ninja ] || cmake --preset release
	@cmake --build $(BUILD)

demo: build
	@mkdir -p out
	@$(GNOMON) demo -o out/demo

report: build
	@mkdir -p out
	@$(GNOMON) report -o out/report

test: build
	@ctest --test-dir $(BUILD) --output-on-failure -j "$$(nproc)"

bench: build
	@benchmarks/run.sh $(GNOMON)

figures: build
	@scripts/setup.sh figures
	@scripts/figures.sh $(GNOMON)

install: build
	cmake --install $(BUILD) --prefix $(PREFIX)

format:
	@scripts/setup.sh checks
	@scripts/format.sh

clean:
	rm -rf build out
