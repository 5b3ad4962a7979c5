#!/bin/bash
# Test everything: install what is missing, then
#   release  gcc, every test
#   clang    the whole tree compiles without a warning
#   asan     address and undefined sanitizers: unit and GPU tests, and hostile input against the program
#   tsan     thread sanitizer: jobs, ECS, scheduling, and the program itself
# The last line counts the test cases of all builds; a build that fails counts as one failed case.
set -euo pipefail
cd "$(dirname "$0")/.."

bash packages.sh

passed=0
failed=0
skipped=0
broken=""

note_failure() { # WHAT
    failed=$((failed + 1))
    broken="$broken
  $1"
}

build() { # PRESET FOLDER [ARGUMENT OF THE BUILD...]; the compiler is in $cc and $cxx
    preset=$1
    folder=$2
    shift 2
    echo "==== $folder: build"
    if ! { cmake --preset "$preset" -B "build/$folder" -DCMAKE_C_COMPILER="$cc" -DCMAKE_CXX_COMPILER="$cxx" &&
           cmake --build "build/$folder" "$@"; }; then
        note_failure "$folder does not build"
        return 1
    fi
}

count() { # PATTERN: lines of the test report that match
    grep -c "$1" "$report" || true
}

run_tests() { # FOLDER [ARGUMENT OF CTEST...]
    folder=$1
    shift
    report="$PWD/build/$folder/report.xml"
    rm -f "$report"
    echo "==== $folder: test"
    rc=0
    # shellcheck disable=SC2086 # the wrapper is a command with its arguments
    $wrapper ctest --test-dir "build/$folder" --parallel 2 --output-on-failure --no-tests=error \
        --output-junit "$report" "$@" || rc=$?
    if [ ! -s "$report" ]; then
        note_failure "$folder: no test ran"
        return
    fi
    all=$(count '^[[:space:]]*<testcase ')
    good=$(count '^[[:space:]]*<testcase .*status="run"')
    left=$(($(count '<skipped message="SKIP_') + $(count '^[[:space:]]*<testcase .*status="disabled"')))
    bad=$((all - good - left)) # a test whose program is missing is no skipped one
    passed=$((passed + good))
    failed=$((failed + bad))
    skipped=$((skipped + left))
    if [ "$rc" -ne 0 ]; then
        broken="$broken
  $folder: $bad of $all test cases"
        if [ "$bad" -eq 0 ]; then
            note_failure "$folder: ctest ended with $rc"
        fi
    fi
}

targets_of() { # PATTERN...: the executables of the unit tests that match
    for pattern in "$@"; do
        for file in tests/unit/$pattern; do
            if [ -e "$file" ]; then
                echo "--target $(basename "$file" .c)_test"
            fi
        done
    done
}

wrapper=""
cc=gcc cxx=g++
if build release release; then
    run_tests release
fi

cc=clang cxx=clang++
build debug clang || true

cc=gcc cxx=g++
if build asan asan; then
    run_tests asan --label-regex '^(unit|gpu|fuzz)$'
fi

# The thread sanitizer of gcc 12 cannot live with the address layout of newer kernels unless it is fixed.
if setarch "$(uname -m)" -R true 2> /dev/null; then
    wrapper="setarch $(uname -m) -R"
fi
threaded=$(targets_of 'jobs_*.c' 'ecs_*.c' '*schedule*.c' 'app_program.c')
# shellcheck disable=SC2086 # one word a target
if build tsan tsan --target kandil $threaded; then
    run_tests tsan --tests-regex '^(jobs_|ecs_|app_program|.*schedule)'
fi

echo
if [ -n "$broken" ]; then
    echo "what failed:$broken"
    echo
fi
echo "$passed passed, $failed failed, $skipped skipped"
[ "$failed" -eq 0 ]
