#include <cstdio>

#include "calib/solver_messages.h"
#include "host/cli/run.h"

int main(int argc, char** argv) {
    std::setvbuf(stdout, nullptr, _IOLBF, BUFSIZ);  // what is said shows at once, in a pipe too
    stria::silence_solver_warnings();               // the verbs say what came of a solve
    return stria::run_program(argc, argv);
}
