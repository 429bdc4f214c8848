#pragma once

#include <CLI/App.hpp>
#include <filesystem>
#include <string>

#include "dicom/archive.hpp"
#include "pipeline/cli/shared_options.hpp"

/// The commands that speak with a picture archive (PACS).
namespace angio::pipeline {

/// Which archive, and how we are known there.
struct ArchiveArguments {
  std::string address;  ///< AET@HOST:PORT
  std::string calling = "ANGIO";
  double timeout_s = 30.0;

  [[nodiscard]] dicom::ArchiveAddress parsed() const;
};

struct SendArguments {
  std::filesystem::path case_folder;
  ArchiveArguments archive;
  bool keep_link = false;
  SharedOptions shared;
};
CLI::App& add_send_command(CLI::App& app, SendArguments& send);
/// Makes a case's DICOM objects in a temporary folder and sends them. @return the exit code
int do_send(const SendArguments& send);

struct FetchArguments {
  ArchiveArguments archive;
  dicom::ArchiveQuery query;
  std::filesystem::path folder;
  SharedOptions shared;
};
CLI::App& add_fetch_command(CLI::App& app, FetchArguments& fetch);
int do_fetch(const FetchArguments& fetch);

/// --calling: our title towards an archive.
CLI::Option* add_calling_option(CLI::App& command, std::string& calling);

}  // namespace angio::pipeline
