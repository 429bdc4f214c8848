#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "pipeline/case/case_folder.hpp"
#include "pipeline/case/running_case.hpp"
#include "run_program.hpp"

namespace angio::pipeline {
namespace {

namespace fs = std::filesystem;

TEST(Sha256, AgreesWithTheStandard) {
  // FIPS 180-4, the one-block example "abc".
  EXPECT_EQ(sha256_of_text("abc"),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(Sha256, OfAFolderDependsOnContentOnly) {
  test::CommandFolder a, b;
  for (const auto& folder : {&a, &b}) {
    write_text_atomically(*folder / "1.dcm", "one");
    write_text_atomically(*folder / "2.dcm", "two");
  }
  EXPECT_EQ(sha256_of_path(a.path()), sha256_of_path(b.path()));
  write_text_atomically(b / "2.dcm", "three");
  EXPECT_NE(sha256_of_path(a.path()), sha256_of_path(b.path()));
}

TEST(StageFolder, AppearsAtOnceAndReplacesTheFormer) {
  test::CommandFolder root;
  const CaseFolder folder(root.path());
  write_text_atomically(root / "meshing/old.txt", "old");
  {
    StageFolder stage(folder, Stage::meshing);
    write_text_atomically(stage.path() / "new.txt", "new");
    EXPECT_TRUE(folder.exists("meshing/old.txt"));
    stage.commit();
  }
  EXPECT_FALSE(folder.exists("meshing/old.txt"));
  EXPECT_TRUE(folder.exists("meshing/new.txt"));
}

TEST(StageFolder, LeavesTheCaseAsItWasWhenTheWorkFails) {
  test::CommandFolder root;
  const CaseFolder folder(root.path());
  write_text_atomically(root / "meshing/old.txt", "old");
  {
    StageFolder stage(folder, Stage::meshing);
    write_text_atomically(stage.path() / "half.txt", "half");
  }
  EXPECT_TRUE(folder.exists("meshing/old.txt"));
  EXPECT_EQ(std::distance(fs::directory_iterator(root.path()), fs::directory_iterator()), 1);
}

TEST(CaseFolder, KeepsItsRecord) {
  test::CommandFolder root;
  const CaseFolder folder(root.path());
  RunRecord record;
  record.case_name = "demo";
  record.input_sha256 = "123";
  StageRecord& entry = record.stages[Stage::meshing];
  entry.status = "done";
  entry.outputs = {{"b", "2"}};
  entry.warnings = {"a warning"};
  entry.time_split = {{"air", 0.2}};
  folder.write_record(record);
  const RunRecord again = folder.read_record();
  EXPECT_EQ(again.case_name, "demo");
  EXPECT_EQ(again.stages.at(Stage::meshing).outputs.at("b"), "2");
  EXPECT_EQ(again.stages.at(Stage::meshing).warnings.front(), "a warning");
  EXPECT_EQ(again.stages.at(Stage::meshing).time_split.at("air"), 0.2);
}

TEST(CaseFolder, RefusesAFolderOfAnotherCaseOrOfSomebodyElse) {
  test::CommandFolder root;
  const CaseFolder folder(root.path());
  RunRecord record;
  record.input_sha256 = "one";
  folder.claim(record, false);
  folder.write_record(record);
  EXPECT_NO_THROW(folder.claim(record, false));
  RunRecord other;
  other.input_sha256 = "two";
  EXPECT_THROW(folder.claim(other, false), IoError);
  EXPECT_NO_THROW(folder.claim(other, true));

  test::CommandFolder foreign;
  write_text_atomically(foreign / "holiday.txt", "photos");
  EXPECT_THROW(CaseFolder(foreign.path()).claim(record, false), IoError);
}

TEST(CaseFolder, AStageIsUpToDateOnlyWithItsKeyAndWholeOutputs) {
  test::CommandFolder root;
  const CaseFolder folder(root.path());
  write_text_atomically(root / "meshing/lumen.vtp", "content");
  StageRecord record;
  record.status = "done";
  record.key = "key";
  record.outputs = folder.hashes({"meshing/lumen.vtp"});
  EXPECT_TRUE(folder.is_up_to_date(record, "key"));
  EXPECT_FALSE(folder.is_up_to_date(record, "another key"));
  write_text_atomically(root / "meshing/lumen.vtp", "changed");
  EXPECT_FALSE(folder.is_up_to_date(record, "key"));
  fs::remove(root.path() / "meshing/lumen.vtp");
  EXPECT_FALSE(folder.is_up_to_date(record, "key"));
}

TEST(CaseLock, KeepsASecondRunOut) {
  test::CommandFolder root;
  const CaseFolder folder(root.path());
  const CaseLock first(folder);
  EXPECT_THROW(CaseLock{folder}, IoError);
}

TEST(LockNote, NamesTheProcessThatIsAtWork) {
  test::CommandFolder root;
  const CaseFolder folder(root.path());
  {
    const CaseLock first(folder);
    const LockNote note(folder);
    try {
      const CaseLock second(folder);
      FAIL();
    } catch (const IoError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("process " + std::to_string(getpid()) + " on "));
    }
  }
  EXPECT_TRUE(std::filesystem::is_empty(root.path()));
}

TEST(RunningCase, WhatAKilledRunLeavesKeepsNobodyOut) {
  test::CommandFolder root;
  const CaseFolder folder(root.path());
  write_text_atomically(root / ".lock", "process 1 on nowhere\n");
  write_text_atomically(root / ".run.tmp-7.json", "{");
  EXPECT_TRUE(is_free(folder));
  EXPECT_NO_THROW(CaseLock{folder});  // nobody holds it
  remove_leftovers(folder);
  EXPECT_FALSE(folder.exists(".run.tmp-7.json"));
  write_text_atomically(root / "notes.txt", "somebody's");
  EXPECT_FALSE(is_free(folder));
}

}  // namespace
}  // namespace angio::pipeline
