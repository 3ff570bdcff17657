#include <cstdio>

#include "host/cli/run.h"

int main(int argc, char** argv) {
    std::setvbuf(stdout, nullptr, _IOLBF, BUFSIZ);  // what is said shows at once, in a pipe too
    return stria::run_program(argc, argv);
}
