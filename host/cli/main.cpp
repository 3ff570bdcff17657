#include "host/cli/run.h"

int main(int argc, char** argv) { return stria::run_program(argc, argv); }
