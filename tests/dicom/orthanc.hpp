#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>

#include "core/atomic_file.hpp"
#include "core/child_process.hpp"
#include "dicom/archive.hpp"
#include "testing/temporary_folder.hpp"

namespace angio::test {

/// A picture archive of our own: Debian's Orthanc on the loopback, with its own configuration and
/// folder; ends with this.
class Orthanc {
 public:
  /// Where the program is; empty where it is not installed.
  static std::string program() {
    for (const char* place : {"/usr/sbin/Orthanc", "/usr/bin/Orthanc"})
      if (access(place, X_OK) == 0) return place;
    return {};
  }

  Orthanc() : port_(free_port()) {
    write_text_atomically(folder_ / "orthanc.json", configuration());
    const ProgramCall call{
        program(), {(folder_ / "orthanc.json").string()}, folder_ / "log", Session::its_own};
    process_ = std::make_unique<ChildProgram>(call);
  }

  [[nodiscard]] dicom::ArchiveAddress address() const {
    return dicom::parse_archive_address(text());
  }
  [[nodiscard]] std::string text() const { return "ARCHIVE@127.0.0.1:" + std::to_string(port_); }

  /// Does it take connections within some seconds?
  [[nodiscard]] bool answers() const {
    for (int attempt = 0; attempt < 150; ++attempt) {
      if (accepts(port_)) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    return false;
  }

 private:
  static sockaddr_in loopback(int port) {
    sockaddr_in place{};
    place.sin_family = AF_INET;
    place.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    place.sin_port = htons(static_cast<std::uint16_t>(port));
    return place;
  }
  static bool accepts(int port) {
    const int file = socket(AF_INET, SOCK_STREAM, 0);
    const sockaddr_in place = loopback(port);
    const bool done = connect(file, reinterpret_cast<const sockaddr*>(&place), sizeof place) == 0;
    close(file);
    return done;
  }
  static int free_port() {
    const int file = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in place = loopback(0);
    bind(file, reinterpret_cast<const sockaddr*>(&place), sizeof place);
    socklen_t size = sizeof place;
    getsockname(file, reinterpret_cast<sockaddr*>(&place), &size);
    close(file);
    return ntohs(place.sin_port);
  }
  [[nodiscard]] std::string configuration() const {
    const std::string folder = folder_.path().string();
    return R"({"Name":"test","StorageDirectory":")" + folder + R"(/store","IndexDirectory":")" +
           folder + R"(/index","Plugins":[],"HttpServerEnabled":false,"DicomAet":"ARCHIVE",)" +
           R"("DicomCheckCalledAet":true,"DicomPort":)" + std::to_string(port_) +
           R"(,"DicomAlwaysAllowEcho":true,"DicomAlwaysAllowStore":true,)" +
           R"("DicomAlwaysAllowFind":true,"DicomAlwaysAllowGet":true,"DicomModalities":{},)" +
           R"("DicomCheckModalityHost":false})";
  }

  TemporaryFolder folder_;
  int port_;
  std::unique_ptr<ChildProgram> process_;
};

}  // namespace angio::test
