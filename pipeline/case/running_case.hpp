#pragma once

#include <filesystem>
#include <string>

#include "pipeline/case/case_folder.hpp"

/// What a run puts into its case while it is at work, and leaves there when it is killed.
namespace angio::pipeline {

/// While it lives, the case's file .lock says who is at work, for people: the lock itself
/// (CaseLock) ends with its process, so that what a killed run left of this file keeps nobody out.
class LockNote {
 public:
  explicit LockNote(const CaseFolder& folder);
  ~LockNote();
  LockNote(const LockNote&) = delete;
  LockNote& operator=(const LockNote&) = delete;

 private:
  std::filesystem::path file_;
};

/// "process 12 on host", by the note; empty where there is none.
std::string who_is_at_work(const CaseFolder& folder);

/// Whether there is no folder, or one with nothing in it but what a run leaves that is killed at
/// its very beginning.
bool is_free(const CaseFolder& folder);

/// Removes what killed runs have left half-written beside the case's own files.
void remove_leftovers(const CaseFolder& folder);

}  // namespace angio::pipeline
