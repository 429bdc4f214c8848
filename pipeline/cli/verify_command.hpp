#pragma once

#include <CLI/App.hpp>
#include <filesystem>
#include <vector>

namespace angio::pipeline {

struct VerifyArguments {
  std::vector<std::filesystem::path> cases;
  bool as_json = false;
};

void add_verify_command(CLI::App& app, VerifyArguments& verify);

/// Lists what differs in each case. @return 0 if nothing does, otherwise 65
int do_verify(const VerifyArguments& arguments);

}  // namespace angio::pipeline
