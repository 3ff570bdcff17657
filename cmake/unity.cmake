# The presets asan, tsan, arm64 and coverage, tools/check --all and tools/quickstart join a target's
# sources into few (CMAKE_UNITY_BUILD): most of a compiler's time goes into the same headers. The
# release preset compiles each file alone, so that a change costs one file.
# These files stay alone there too: another file of their target has a file-local name of theirs, or
# (point_tree, scene_geometry) a class of theirs has a member of a file-local type, of which g++
# warns outside a main file.
set(stria_alone
    calib/degeneracies.cpp
    calib/held_out_check.cpp
    calib/point_moves.cpp
    calib/scanner_calibration.cpp
    calib/stripe_line.cpp
    calib/stripe_points.cpp
    calib/view_degeneracies.cpp
    firmware/stripe/deconvolution.cpp
    firmware/stripe/spacetime_engine.cpp
    host/advise/depth_advice.cpp
    host/advise/design.cpp
    host/cli/verb_verify_bar.cpp
    host/cli/verb_verify_plane.cpp
    host/geometry/point_tree.cpp
    host/geometry/surface_tree.cpp
    host/io/scanner_toml.cpp
    host/scan/centre_of_light.cpp
    host/scan/judge_pulses.cpp
    host/verify/flatness.cpp
    host/verify/plane_patch.cpp
    sim/bounce_light.cpp
    sim/lit_patches.cpp
    sim/mirror_light.cpp
    sim/scene_geometry.cpp
    tests/firmware/session/set_paths_test.cpp
    tests/firmware/stripe/lit_profile.cpp
    tests/firmware/stripe/reflectance_card.cpp
    tests/firmware/stripe/reflectance_card_test.cpp
    tests/firmware/stripe/temporal_trials.cpp
    tests/host/advise/design_test.cpp
    tests/host/link/set_paths_test.cpp
    tests/host/scan/clock_delay_test.cpp
    tests/host/scan/merge_passes_test.cpp
    tests/host/scan/range_from_pulses_test.cpp
    tests/host/verify/flatness_test.cpp
    tests/sim/light_shape_test.cpp
    tests/sim/speckle_scene_test.cpp
    tests/sim/speckle_trials.cpp
    tests/structure/readme_test.cpp)
if(STRIA_FIRMWARE_ONLY)
    list(FILTER stria_alone INCLUDE REGEX firmware/)
endif()
if(NOT STRIA_TESTS)
    list(FILTER stria_alone EXCLUDE REGEX ^tests/)
endif()
foreach(file IN LISTS stria_alone)
    get_filename_component(folder ${PROJECT_SOURCE_DIR}/${file} DIRECTORY)
    if(NOT EXISTS ${PROJECT_SOURCE_DIR}/${file})
        message(FATAL_ERROR "cmake/unity.cmake names ${file}, which is not there")
    endif()
    set_source_files_properties(${PROJECT_SOURCE_DIR}/${file} DIRECTORY ${folder}
                                PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endforeach()
