#include "viewer/window/run_watch.hpp"

#include <utility>

#include "formats/case_file.hpp"
#include "viewer/detail/case_data.hpp"

namespace angio::viewer::window {
namespace case_file = formats::case_file;
namespace fs = std::filesystem;

RunWatch::RunWatch(fs::path case_folder) : folder_(std::move(case_folder)), times_(read_times()) {}

RunWatch::Times RunWatch::read_times() const {
  Times times;
  const fs::path frames = detail::simulation_folder(folder_);
  const fs::path list = frames / fs::path(case_file::kFrameList).filename();
  for (const fs::path& file : {folder_ / case_file::kRun, folder_ / case_file::kMetrics,
                               folder_ / case_file::kLumen, list}) {
    std::error_code error;
    const fs::file_time_type time = fs::last_write_time(file, error);
    if (!error) times[file] = time;
  }
  return times;
}

RunWatch::News RunWatch::look() {
  const Times before = std::exchange(times_, read_times());
  if (times_ == before) return News::none;
  const std::string lumen = folder_ / case_file::kLumen;
  const auto now = times_.find(lumen);
  const auto then = before.find(lumen);
  if (now == times_.end()) return News::none;  // it is just being written again
  return then == before.end() || now->second != then->second ? News::lumen : News::frames;
}

}  // namespace angio::viewer::window
