# One small static library per folder: names its sources, links PRIVATE unless a header needs it.
#   stria_library(stria_fusion SOURCES a.cpp b.cpp PUBLIC stria_host_core PRIVATE stria_geometry)
function(stria_library name)
    cmake_parse_arguments(ARG "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
    add_library(${name} STATIC ${ARG_SOURCES})
    target_include_directories(${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
                                              $<INSTALL_INTERFACE:include/stria>)
    target_compile_features(${name} PUBLIC cxx_std_20)
    target_link_libraries(${name} PUBLIC ${ARG_PUBLIC}
                                  PRIVATE ${ARG_PRIVATE} $<BUILD_INTERFACE:stria_warnings>)
    set_property(GLOBAL APPEND PROPERTY STRIA_LIBRARIES ${name})
endfunction()

# Headers only: the devices' interfaces.
function(stria_interface_library name)
    cmake_parse_arguments(ARG "" "" "PUBLIC" ${ARGN})
    add_library(${name} INTERFACE)
    target_include_directories(${name} INTERFACE $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
                                                 $<INSTALL_INTERFACE:include/stria>)
    target_compile_features(${name} INTERFACE cxx_std_20)
    target_link_libraries(${name} INTERFACE ${ARG_PUBLIC})
    set_property(GLOBAL APPEND PROPERTY STRIA_LIBRARIES ${name})
endfunction()

# The time limit of a test that has SECONDS in a Release build.
function(stria_time_limit out seconds)
    math(EXPR limit "${seconds} * ${STRIA_TIME_LIMIT_FACTOR}")
    set(${out} ${limit} PARENT_SCOPE)
endfunction()

# One test program a folder; every TEST in it becomes a ctest of its own.
#   stria_test(fusion_test SOURCES volume_test.cpp LIBS stria_fusion [LABELS long])
function(stria_test name)
    cmake_parse_arguments(ARG "" "TIMEOUT" "SOURCES;LIBS;LABELS" ${ARGN})
    if("long" IN_LIST ARG_LABELS AND NOT STRIA_LONG_TESTS)
        set(only_if_asked EXCLUDE_FROM_ALL)
    endif()
    add_executable(${name} ${only_if_asked} ${ARG_SOURCES})
    target_link_libraries(${name} PRIVATE ${ARG_LIBS} stria_warnings GTest::gtest GTest::gtest_main)
    set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests)
    if(only_if_asked)
        return()
    endif()
    if(NOT ARG_TIMEOUT)
        set(ARG_TIMEOUT 300)
    endif()
    stria_time_limit(limit ${ARG_TIMEOUT})
    set(prefix "")
    if("long" IN_LIST ARG_LABELS)
        set(prefix long.)  # not the name, and so the labels, of the short run of the same source
    endif()
    gtest_discover_tests(${name} DISCOVERY_MODE PRE_TEST TEST_PREFIX "${prefix}"
                         PROPERTIES TIMEOUT ${limit} LABELS "${ARG_LABELS}")
endfunction()

if(STRIA_FUZZERS)
    if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
        message(FATAL_ERROR "STRIA_FUZZERS needs clang: configure with -DCMAKE_CXX_COMPILER=clang++")
    endif()
    add_compile_options(-fsanitize=fuzzer-no-link,address,undefined -fno-omit-frame-pointer)
    add_link_options(-fsanitize=address,undefined)
endif()

# A fuzz target: SOURCES define LLVMFuzzerTestOneInput. Always a plain program NAME that replays
# every file of tests/fuzz/corpus/NAME, and a ctest fuzz.NAME that runs it (label "fuzz"; a corpus
# without files fails). With STRIA_FUZZERS also NAME_libfuzzer, which goes on from that corpus.
#   stria_fuzz(fuzz_framing SOURCES fuzz_framing.cpp LIBS stria_protocol)
function(stria_fuzz name)
    cmake_parse_arguments(ARG "" "TIMEOUT" "SOURCES;LIBS" ${ARGN})
    if(NOT ARG_TIMEOUT)
        set(ARG_TIMEOUT 120)
    endif()
    stria_time_limit(limit ${ARG_TIMEOUT})
    add_executable(${name} ${ARG_SOURCES} ${PROJECT_SOURCE_DIR}/tests/fuzz/replay_main.cpp)
    target_link_libraries(${name} PRIVATE ${ARG_LIBS} stria_warnings)
    set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/fuzz)
    set_property(GLOBAL APPEND PROPERTY STRIA_FUZZ_TARGETS ${name})
    add_test(NAME fuzz.${name} COMMAND ${name} ${PROJECT_SOURCE_DIR}/tests/fuzz/corpus/${name})
    set_tests_properties(fuzz.${name} PROPERTIES TIMEOUT ${limit} LABELS fuzz)
    if(STRIA_FUZZERS)
        add_executable(${name}_libfuzzer ${ARG_SOURCES})
        target_link_libraries(${name}_libfuzzer PRIVATE ${ARG_LIBS} stria_warnings)
        target_link_options(${name}_libfuzzer PRIVATE -fsanitize=fuzzer)
        set_target_properties(${name}_libfuzzer PROPERTIES
                              RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/fuzz)
        set_property(GLOBAL APPEND PROPERTY STRIA_LIBFUZZER_TARGETS ${name}_libfuzzer)
    endif()
endfunction()
