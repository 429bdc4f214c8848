#include "segmentation/dicom_link.hpp"

#include <array>
#include <string>

#include "core/child_process.hpp"
#include "core/error.hpp"
#include "segmentation/detail/dicom_load.hpp"
#include "segmentation/detail/dicom_parse.hpp"
#include "segmentation/detail/dicom_series.hpp"
#include "segmentation/detail/source_identity.hpp"
#include "segmentation/detail/volume_file.hpp"
#include "segmentation/read_run.hpp"

namespace angio::segmentation {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kMemoryBytes = std::size_t(1) << 30;

std::array<std::string*, 12> texts_of(dicom::StudyIdentity& identity) {
  return {&identity.patient_name,        &identity.patient_id,
          &identity.birth_date,          &identity.sex,
          &identity.study_uid,           &identity.study_id,
          &identity.study_date,          &identity.study_time,
          &identity.study_description,   &identity.accession_number,
          &identity.referring_physician, &identity.frame_of_reference_uid};
}

/// Reads identity and modality in a guarded child, as every header.
void add_identity(const detail::DicomHeader& header, dicom::SourceLink& link) {
  detail::prepare_dcmtk();
  ChildLimits limits{kMemoryBytes, 60, 60};
  limits.reach.read = {header.source.path};
  const ChildResult result = run_guarded(
      limits,
      [&](ChildOutput& output) {
        dicom::StudyIdentity found = detail::source_identity(header.source, header.series_uid);
        for (const std::string* text : texts_of(found)) output.put(*text);
        output.put(detail::source_modality(header.source));
        output.flush();
      },
      [&](ChildInput& input) {
        for (std::string* text : texts_of(link.identity)) input.get(*text);
        input.get(link.modality);
      });
  if (result.end == ChildEnd::refused) throw IoError(result.message);
  if (result.end != ChildEnd::done)
    throw IoError("the scan's header cannot be read again (it is damaged now). Run from it again");
}

/// The series that read_volume, or read_run, takes.
const detail::DicomSeries& chosen_series(const std::vector<detail::DicomSeries>& all,
                                         const fs::path& source, const ReadOptions& options) {
  if (options.series.empty() && is_rotational_run(source, options)) {
    const detail::DicomSeries* largest = nullptr;
    for (const detail::DicomSeries& series : all) {
      if (series.headers.empty() || !series.headers.front().projection) continue;
      const bool is_filled = series.headers.front().projection->has_contrast_medium;
      if (largest == nullptr || (is_filled && series.pixel_count() == largest->pixel_count() &&
                                 !largest->headers.front().projection->has_contrast_medium))
        largest = &series;
    }
    if (largest != nullptr) return *largest;
  }
  return all[detail::choose_series(all, options)];
}

}  // namespace

dicom::SourceLink read_source_link(const fs::path& source, const ReadOptions& options) {
  if (detail::is_volume_file_name(source) && !fs::is_directory(source))
    throw InputError(source.filename().string() +
                     " is no DICOM (it has no patient and no study to refer to). Leave out "
                     "--keep-link");
  const detail::FoundSeries found = detail::find_series(source, options);
  if (found.all.empty())
    throw InputError(
        "the scan that the case was made from holds no DICOM any more. Leave out "
        "--keep-link, or run from it again");
  const detail::DicomSeries& series = chosen_series(found.all, source, options);
  dicom::SourceLink link;
  add_identity(series.headers.front(), link);
  link.series_uid = series.headers.front().series_uid;
  for (const detail::DicomHeader& header : series.headers)
    link.objects.push_back({header.sop_class_uid, header.instance_uid});
  return link;
}

}  // namespace angio::segmentation
