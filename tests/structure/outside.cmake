# Builds and runs the outside program of one component against an installed stria, and looks at what
# it asked for and loads.
#   cmake -D BUILD=.. -D SOURCE=.. -D COMPONENT=.. -D FREE_OF=ceres,opencv -P outside.cmake
set(prefix ${BUILD}/outside/prefix)
set(work ${BUILD}/outside/${COMPONENT})
file(REMOVE_RECURSE ${work})

function(run)
    execute_process(COMMAND ${ARGV} RESULT_VARIABLE result OUTPUT_VARIABLE output
                    ERROR_VARIABLE output)
    if(NOT result EQUAL 0)
        list(JOIN ARGV " " command)
        message(FATAL_ERROR "${command}\n${output}")
    endif()
    set(output "${output}" PARENT_SCOPE)
endfunction()

run(${CMAKE_COMMAND} -G Ninja -S ${SOURCE} -B ${work} -D CMAKE_BUILD_TYPE=Release
    -D CMAKE_PREFIX_PATH=${prefix} -D COMPONENT=${COMPONENT})
run(${CMAKE_COMMAND} --build ${work})
run(${work}/outside)

file(READ ${work}/CMakeCache.txt asked)
run(ldd ${work}/outside)
string(REPLACE "," ";" FREE_OF "${FREE_OF}")
foreach(name IN LISTS FREE_OF)
    string(TOLOWER "${asked}" lower)
    if(lower MATCHES "\n${name}_dir:")
        message(FATAL_ERROR "find_package(stria COMPONENTS ${COMPONENT}) looked for ${name}")
    endif()
    if(output MATCHES "lib${name}")
        message(FATAL_ERROR "the outside program of ${COMPONENT} loads ${name}:\n${output}")
    endif()
endforeach()
