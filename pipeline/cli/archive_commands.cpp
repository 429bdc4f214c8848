#include "pipeline/cli/archive_commands.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "core/error.hpp"
#include "core/scratch_folder.hpp"
#include "pipeline/case/dicom_folder.hpp"
#include "pipeline/stages/reporter.hpp"
#include "pipeline/stages/stage_work.hpp"

namespace angio::pipeline {
namespace {

void add_connection_options(CLI::App& command, ArchiveArguments& archive) {
  add_calling_option(command, archive.calling);
  command
      .add_option("--timeout", archive.timeout_s,
                  "seconds to wait for the archive, each time, 1 to 3600")
      ->type_name("S")
      ->capture_default_str();
}

}  // namespace

CLI::Option* add_calling_option(CLI::App& command, std::string& calling) {
  return command
      .add_option("--calling", calling,
                  "our application entity title towards an archive, which may have to know it; "
                  "ANGIO unless given")
      ->type_name("AET");
}

dicom::ArchiveAddress ArchiveArguments::parsed() const {
  dicom::ArchiveAddress result = dicom::parse_archive_address(address);
  result.our_ae_title = calling;
  result.timeout_s = timeout_s;
  result.validate();
  return result;
}

CLI::App& add_send_command(CLI::App& app, SendArguments& send) {
  CLI::App& command = *app.add_subcommand(
      "send",
      "a case into a picture archive (PACS): the report as encapsulated PDF, its numbers as\n"
      "structured report, the lumen as segmentation; under a patient and study of their own");
  command.add_option("CASE", send.case_folder, "the case's folder")->required();
  command.add_option("--to", send.archive.address, "the archive")
      ->required()
      ->type_name("AET@HOST:PORT");
  command.add_flag("--keep-link", send.keep_link,
                   "under the scan's patient and study, with references to its images (the case "
                   "was run with --keep-link)");
  add_connection_options(command, send.archive);
  add_output_options(command, send.shared);
  return command;
}

int do_send(const SendArguments& send) {
  const dicom::ArchiveAddress address = send.archive.parsed();
  Reporter reporter(send.shared.style());
  reporter.begin_stage("send");
  const ScratchFolder folder("angio-send");
  const Progress whole = reporter.progress();
  const auto files = write_dicom_folder(send.case_folder, folder.path(),
                                        send.keep_link ? DicomLink::source : DicomLink::none,
                                        part(whole, 0.0, 0.5));
  dicom::send_to_archive(address, files, part(whole, 0.5, 1.0));
  for (const auto& file : files)
    reporter.result(fmt::format("{} sent to {}", file.filename().string(), address.ae_title));
  return int(ExitCode::done);
}

CLI::App& add_fetch_command(CLI::App& app, FetchArguments& fetch) {
  CLI::App& command = *app.add_subcommand(
      "fetch",
      "a study's series from a picture archive (PACS) into a folder, as they are: with the\n"
      "patient's data, readable by you only. One study is named by --study, --accession,\n"
      "--patient-id and --date together");
  command.add_option("ARCHIVE", fetch.archive.address, "AET@HOST:PORT")->required();
  command.add_option("-o,--output", fetch.folder, "a new folder")->required()->type_name("FOLDER");
  command.add_option("--study", fetch.query.study_uid, "the study's UID")->type_name("UID");
  command.add_option("--series", fetch.query.series_uid, "one series, by its UID")
      ->type_name("UID");
  command.add_option("--accession", fetch.query.accession_number, "the study's accession number")
      ->type_name("NUMBER");
  command.add_option("--patient-id", fetch.query.patient_id, "the patient's identifier")
      ->type_name("ID");
  command.add_option("--date", fetch.query.study_date, "the study's date, or a range of dates")
      ->type_name("YYYYMMDD[-YYYYMMDD]");
  command.add_option("--modality", fetch.query.modality, "only series of this kind: XA, CT, ...")
      ->type_name("XA");
  add_connection_options(command, fetch.archive);
  add_output_options(command, fetch.shared);
  return command;
}

int do_fetch(const FetchArguments& fetch) {
  const dicom::ArchiveQuery& query = fetch.query;
  if (query.study_uid.empty() && query.accession_number.empty() && query.patient_id.empty())
    throw Error(
        ExitCode::usage,
        "`angio fetch` needs to know which study. Give --study, --accession or --patient-id");
  Reporter reporter(fetch.shared.style());
  reporter.begin_stage("fetch");
  const dicom::Fetched fetched =
      dicom::fetch_from_archive({fetch.archive.parsed(), query}, fetch.folder, reporter.progress());
  reporter.note(fmt::format("{} objects of {} series", fetched.object_count, fetched.series_count));
  reporter.result(fetch.folder.string());
  return int(ExitCode::done);
}

}  // namespace angio::pipeline
