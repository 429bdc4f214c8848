#include "pipeline/commands.hpp"

int main(int argc, char** argv) { return angio::pipeline::run_command_line(argc, argv); }
