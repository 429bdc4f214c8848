#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "testing/viewer/case_folder.hpp"
#include "testing/viewer/shapes.hpp"
#include "viewer/detail/film_file.hpp"
#include "viewer/film.hpp"

namespace angio::viewer {
namespace {
namespace fs = std::filesystem;
using test::TemporaryFolder;
using test::write_case;
using testing::HasSubstr;

constexpr int kRate = 4;           // pictures per second
constexpr int kPictureCount = 31;  // of its 7.5 s
constexpr int kWrittenFrames = 6;  // of write_case
const FilmOptions kSmall{320, 240, kRate};

void write_treated_case(const fs::path& folder) {
  write_case(folder);
  write_text_atomically(folder / "meshing/placement.json",
                        R"({"lesion":{"centerline_id":0,"abscissa_mm":15.3}})");
}

std::vector<cv::Mat> read_film(const fs::path& film) {
  cv::VideoCapture reader(film.string());
  std::vector<cv::Mat> pictures;
  for (cv::Mat picture; reader.read(picture);) pictures.push_back(picture.clone());
  return pictures;
}

/// The share of the pixels that clearly differ.
double changed_share(const cv::Mat& a, const cv::Mat& b) {
  cv::Mat difference;
  cv::absdiff(a, b, difference);
  cv::cvtColor(difference, difference, cv::COLOR_BGR2GRAY);
  return double(cv::countNonZero(difference > 30)) / double(difference.total());
}

std::size_t file_count(const fs::path& folder) {
  return std::size_t(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

class Film : public testing::TestWithParam<const char*> {};

TEST_P(Film, IsReadBackWithEveryPictureAndTheBalloonWiderAtPeak) {
  const TemporaryFolder folder;
  write_treated_case(folder / "case");
  const fs::path film = folder / "films" / (std::string("out") + GetParam());
  EXPECT_EQ(write_film(folder / "case", film, kSmall), kPictureCount);
  EXPECT_EQ(file_count(folder / "films"), 1u);  // nothing temporary is left
  // Theora keeps a picture that is the one before as an empty packet, which OpenCV's reader skips:
  // there the length counts.
  const cv::VideoCapture reader(film.string());
  EXPECT_EQ(reader.get(cv::CAP_PROP_FPS), kRate);
  EXPECT_NEAR(reader.get(cv::CAP_PROP_FRAME_COUNT), kPictureCount, 0.5);
  const std::vector<cv::Mat> pictures = read_film(film);
  ASSERT_GE(pictures.size(),
            std::size_t(film.extension() == ".ogv" ? kWrittenFrames : kPictureCount));
  EXPECT_LE(pictures.size(), std::size_t(kPictureCount));
  for (const cv::Mat& picture : pictures) EXPECT_EQ(picture.size(), cv::Size(320, 240));
  // The balloon lies in the middle, paper in the corner.
  const cv::Rect middle(80, 90, 160, 60), corner(0, 190, 100, 20);
  double most = 0.0, moved = 0.0;
  for (const cv::Mat& picture : pictures) {
    most = std::max(most, changed_share(pictures.front()(middle), picture(middle)));
    moved = std::max(moved, changed_share(pictures.front()(corner), picture(corner)));
  }
  EXPECT_GT(most, 0.3);
  EXPECT_EQ(moved, 0.0);
  EXPECT_EQ(changed_share(pictures.front()(middle), pictures[1](middle)), 0.0);  // still at 0.25 s
}

INSTANTIATE_TEST_SUITE_P(OfEveryKind, Film, testing::Values(".mp4", ".avi", ".ogv"));

TEST(FilmRefusal, NamesTheFileThatWasAskedFor) {
  const TemporaryFolder folder;
  try {
    const detail::FilmFile film(folder / "none/.a.tmp-7.ogv", folder / "none/a.ogv", 160, 120, 25);
    FAIL();
  } catch (const IoError& error) {
    EXPECT_NE(std::string(error.what()).find("none/a.ogv"), std::string::npos) << error.what();
  }
}

TEST(FilmRefusal, NamesTheEndingsThatWorkAndLeavesNothing) {
  const TemporaryFolder folder;
  write_case(folder / "case");
  try {
    write_film(folder / "case", folder / "films" / "out.gif", kSmall);
    FAIL() << "a .gif was written";
  } catch (const Error& error) {
    EXPECT_EQ(error.exit_code(), ExitCode::usage);
    EXPECT_THAT(error.what(), HasSubstr(".mp4, .avi or .ogv"));
  }
  EXPECT_FALSE(fs::exists(folder / "films"));
}

TEST(FilmRefusal, CaseWithoutSimulationSaysWhatToRun) {
  const TemporaryFolder folder;
  write_case(folder / "case");
  fs::remove_all(folder / "case" / "simulation");
  try {
    write_film(folder / "case", folder / "out.mp4", kSmall);
    FAIL() << "a film of nothing was written";
  } catch (const Error& error) {
    EXPECT_EQ(error.exit_code(), ExitCode::no_input);
    EXPECT_THAT(error.what(), HasSubstr("angio simulate"));
  }
  EXPECT_FALSE(fs::exists(folder / "out.mp4"));
}

TEST(FilmRefusal, DamagedFrameLeavesNoHalfFilm) {
  const TemporaryFolder folder;
  write_case(folder / "case");
  write_text_atomically(folder / "case/simulation/frames/vessel_000060.vtp", "nothing");
  EXPECT_THROW(write_film(folder / "case", folder / "films" / "out.avi", kSmall), InputError);
  EXPECT_EQ(file_count(folder / "films"), 0u);
}

TEST(FilmOptions, DefaultsAreValid) { EXPECT_NO_THROW(FilmOptions().validate()); }

TEST(FilmOptions, OddOrHugeSizesAndRatesAreRefused) {
  for (const FilmOptions& bad : {FilmOptions{641, 480, 25}, FilmOptions{640, 481, 25},
                                 FilmOptions{8000, 480, 25}, FilmOptions{640, 480, 0}})
    EXPECT_THROW(bad.validate(), OptionError);
}

}  // namespace
}  // namespace angio::viewer
