# What a cross build cannot take from the build machine's packages, under the names they give it.

# FlatBuffers: its headers suffice; flatc runs on the build machine.
add_library(flatbuffers INTERFACE)
target_include_directories(flatbuffers SYSTEM INTERFACE ${sysroot}/usr/include)
add_library(flatbuffers::flatbuffers ALIAS flatbuffers)
find_program(STRIA_FLATC flatc REQUIRED)
add_executable(flatbuffers::flatc IMPORTED)
set_target_properties(flatbuffers::flatc PROPERTIES IMPORTED_LOCATION ${STRIA_FLATC})

# GoogleTest, from the sources that Debian's package googletest installs.
if(STRIA_TESTS)
    set(googletest /usr/src/googletest/googletest)
    add_library(gtest STATIC ${googletest}/src/gtest-all.cc)
    target_include_directories(gtest SYSTEM PUBLIC ${googletest}/include PRIVATE ${googletest})
    target_link_libraries(gtest PUBLIC Threads::Threads)
    add_library(gtest_main STATIC ${googletest}/src/gtest_main.cc)
    target_link_libraries(gtest_main PUBLIC gtest)
    add_library(GTest::gtest ALIAS gtest)
    add_library(GTest::gtest_main ALIAS gtest_main)
endif()
