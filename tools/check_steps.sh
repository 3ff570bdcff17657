# shellcheck shell=bash
# The steps of tools/check, one function each; called in the repository's root.
# A step returns 77 when it cannot run here, with the reason as its last line.
# shellcheck source=tools/jobs.sh
. tools/jobs.sh
export CTEST_OUTPUT_ON_FAILURE=1
export UBSAN_OPTIONS=print_stacktrace=1
export LSAN_OPTIONS=suppressions=$PWD/tools/lsan.supp,print_suppressions=0
export TSAN_OPTIONS=second_deadlock_stack=1:suppressions=$PWD/tools/tsan.supp:print_suppressions=0

# The folders whose tests run under the thread sanitizer: those that start threads.
threaded=(firmware/transport firmware/session host/link host/local host/geometry)

# Thousands of trials against a bound, or the whole way from frames to a mesh, whose parts have tests
# of their own: another instrument or CPU adds minutes to them, not knowledge.
minutes_of_numbers='(Spatial|Temporal)Bound|WithoutSim|SimulatedFramesReachTheBound|^ImagePaths'
minutes_of_numbers+='|^Robustness\.Drops|PeakMethods\.ReachWhat|^ReflectanceCard|^Corner\.'
minutes_of_numbers+='|^WideLens|^Determinism\.Seeds|SaysThatAScanOfAnotherPart'
minutes_of_numbers+='|^FitPulses\.FindsWhatAScan|PeakMethods\.SayTheirOwnSigma'
minutes_of_numbers+='|^CalibrateSheetReal|^ScannerCalibration\.KeepsTheMirror|^CalibrateSheetSimulated'
minutes_of_numbers+='|MeetsThePointErrorAndItsOwnPrediction|PeaksOfEveryMethodLieInOnePlane'
minutes_of_numbers+='|^PlaceScans\.IsTheSameForAnyThreadCount|^FuseBunny'
minutes_of_numbers+='|^CrossValidation\.AModelError|GuidedViewsTeachMore|^TwoSolutions|^Convergence\.'
minutes_of_numbers+='|^CornerNoise\.Of|WhatIsFoundDoesNotDependOnWhatWas'
minutes_of_numbers+='|OnARailHasTheSigmaThatWasAdvised|^LensChoice\.Takes|^ClockDelay\.OfPeaks'
minutes_of_numbers+='|SharedCornersOf|BoardWarpOf\.IsFound|DriftOf\.(What|Noise)|ClockOf\.FindsHowFarTheAxisLagsItsLog/(rail|turntable)'

sources() { find firmware host calib sim tests -name '*.h' -o -name '*.cpp'; }

# run_tests BUILD_DIR NAME LABELS_LEFT_OUT [CTEST OPTIONS]; the result also as build/logs/NAME.xml.
run_tests() {
    local directory=$1 name=$2 left_out=$3
    shift 3
    ctest --test-dir "$directory" -j "$(nproc)" -LE "$left_out" --no-tests=error \
        --output-junit "$PWD/build/logs/$name.xml" "$@"
}

step_format() {
    sources | xargs clang-format-14 --dry-run -Werror &&
        echo "check: $(sources | wc -l) files formatted"
}

# joined: ON where a target's sources are joined into few, which takes two thirds of the time from an
# empty compiler cache; OFF where each is compiled alone, as a developer's next build wants it.
step_build() {
    cmake --preset release -DSTRIA_WERROR=ON -DSTRIA_TESTS=ON -DCMAKE_UNITY_BUILD="${joined:-OFF}" &&
        cmake --build build -j "$(build_jobs)"
}

step_unit() { run_tests build unit long; }

step_demo() {
    build/bin/stria demo --quick --force --out build/demo-quick
}

step_arm64() {
    tools/arm64_sysroot && cmake --preset arm64 -DSTRIA_WERROR=ON &&
        cmake --build build/arm64 -j "$(build_jobs)" &&
        run_tests build/arm64 arm64 long \
            -E "$minutes_of_numbers|^Spacetime\.AnswersSanely|^PeakMethods\.OfAnyImage"
}

step_tsan() {
    local folder targets=()
    cmake --preset tsan || return 1
    for folder in "${threaded[@]}"; do targets+=("tests/$folder/all"); done
    cmake --build build/tsan -j "$(build_jobs)" --target "${targets[@]}" || return 1
    for folder in "${threaded[@]}"; do
        run_tests "build/tsan/tests/$folder" "tsan-${folder//\//-}" long || return 1
    done
}

step_asan() {
    cmake --preset asan && cmake --build build/asan -j "$(build_jobs)" &&
        run_tests build/asan asan 'long|fuzz' -E "$minutes_of_numbers"
}

step_fuzz() { run_tests build/asan fuzz long -L fuzz; }

step_package() { tools/package_check build; }

# Files that differ from the merge base with the main line, else those of the last ten commits.
changed_sources() {
    local base
    if ! git rev-parse --git-dir > /dev/null 2>&1; then
        sources
        return
    fi
    base=$(git merge-base HEAD origin/main 2> /dev/null || git merge-base HEAD main 2> /dev/null)
    if [ -z "$base" ] || [ "$base" = "$(git rev-parse HEAD)" ]; then
        base=$(git rev-list --max-count=11 HEAD | tail -n 1)
    fi
    git diff --name-only --diff-filter=d "$base" -- firmware host calib sim tests
}

# Looks at files until its minutes are used up, and says how many were seen. Findings are questions,
# listed in the log; those that .clang-tidy holds to be bugs are errors, and so is a file that does
# not compile alone.
step_tidy() {
    local minutes=5 file files=() findings=build/logs/tidy.findings
    local errors='warnings-as-errors|clang-diagnostic-error'
    cmake --preset release -B build/tidy -DSTRIA_TESTS=ON > /dev/null &&
        cmake --build build/tidy --target generated/firmware/protocol/wire_generated.h || return 1
    while read -r file; do
        grep -qF "/$file\"" build/tidy/compile_commands.json && files+=("$file")
    done < <(changed_sources | grep '\.cpp$')
    if [ ${#files[@]} -eq 0 ]; then
        echo "check: no source changed"
        return 0
    fi
    rm -rf "$findings"
    mkdir -p "$findings"
    export findings
    # shellcheck disable=SC2016  # expanded by the inner shell
    printf '%s\n' "${files[@]}" | xargs -P "$(nproc)" -n 1 bash -c '
        if [ "$(date +%s)" -ge "$0" ]; then exit 0; fi
        name=$findings/${1//\//_}
        clang-tidy-14 -p build/tidy --quiet --extra-arg=-Wno-unknown-warning-option \
            --extra-arg=-Wno-error "$1" > "$name.run" 2>&1 || true' "$(($(date +%s) + minutes * 60))"
    cat "$findings"/*.run | grep -E '(warning|error): .*\[' | sort -u > "$findings/all"
    cat "$findings/all"
    echo "check: $(find "$findings" -name '*.run' | wc -l) of ${#files[@]} changed sources seen in" \
        "$minutes minutes: $(wc -l < "$findings/all") findings, of which" \
        "$(grep -cE "$errors" "$findings/all") are errors"
    ! grep -qE "$errors" "$findings/all"
}
