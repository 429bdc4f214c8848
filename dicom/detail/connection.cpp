#include "dicom/detail/connection.hpp"

#include <dcmtk/dcmnet/cond.h>
#include <fmt/format.h>

#include <algorithm>

#include "core/error.hpp"

namespace angio::dicom::detail {
namespace {

std::string one_line(const char* text) {
  std::string line = text;
  std::replace_if(
      line.begin(), line.end(), [](char c) { return c == '\n' || c == '\t'; }, ' ');
  return line;
}

}  // namespace

Connection::Connection(const ArchiveAddress& address)
    : address_(address),
      name_(fmt::format("{} at {}:{}", address.ae_title, address.host, address.port)) {
  setAETitle(address.our_ae_title.c_str());
  setPeerAETitle(address.ae_title.c_str());
  setPeerHostName(address.host.c_str());
  setPeerPort(Uint16(address.port));
  setDIMSEBlockingMode(DIMSE_NONBLOCKING);
  setConnectionTimeout(Sint32(address.timeout_s));
  setACSETimeout(Uint32(address.timeout_s));
  setDIMSETimeout(Uint32(address.timeout_s));
  setVerbosePCMode(OFFalse);
}

void Connection::offer(const std::string& sop_class, const OFList<OFString>& syntaxes,
                       T_ASC_SC_ROLE role) {
  addPresentationContext(sop_class.c_str(), syntaxes, role);
}

void Connection::connect() {
  OFCondition done = initNetwork();
  if (done.good()) done = negotiateAssociation();
  if (done.good()) return;
  if (done.code() == DULC_ASSOCIATIONREJECTED)
    throw Error(
        ExitCode::unavailable,
        fmt::format("{} refuses to speak with {} (one of the titles is not known there: {}). "
                    "Check AET, give --calling, or have this computer entered in the archive",
                    name_, address_.our_ae_title, one_line(done.text())));
  if (done == NET_EC_NoAcceptablePresentationContexts)
    throw Error(ExitCode::unavailable,
                fmt::format("{} offers none of the services that this needs. Ask its administrator "
                            "for storage (C-STORE), or query and retrieval (C-FIND, C-GET)",
                            name_));
  throw Error(
      ExitCode::unavailable,
      fmt::format("{} cannot be reached ({}; {:.0f} s are waited at most). Check host and port, "
                  "and a firewall between",
                  name_, one_line(done.text()), address_.timeout_s));
}

void Connection::check_answers() { require(sendECHORequest(0), "C-ECHO"); }

T_ASC_PresentationContextID Connection::context_of(const std::string& sop_class,
                                                   const std::string& what) {
  const T_ASC_PresentationContextID id = findAnyPresentationContextID(sop_class.c_str(), "");
  if (id == 0)
    throw Error(
        ExitCode::unavailable,
        fmt::format("{} does not take part in {}. Ask its administrator to allow it", name_, what));
  return id;
}

void Connection::require(const OFCondition& condition, const std::string& what) const {
  if (condition.bad())
    throw Error(ExitCode::unavailable,
                fmt::format("{} did not answer a {} ({}). Try again, or give a longer --timeout",
                            name_, what, one_line(condition.text())));
}

OFList<OFString> uncompressed_syntaxes() {
  OFList<OFString> syntaxes;
  syntaxes.push_back(UID_LittleEndianExplicitTransferSyntax);
  syntaxes.push_back(UID_LittleEndianImplicitTransferSyntax);
  return syntaxes;
}

std::string status_text(Uint16 status) {
  const char* meaning = "failure";
  if ((status & 0xff00) == 0xa700) meaning = "out of resources";
  if ((status & 0xff00) == 0xa900) meaning = "does not match the class";
  if ((status & 0xf000) == 0xc000) meaning = "cannot be understood";
  if (status == 0x0122) meaning = "class not supported";
  if (status == 0x0124) meaning = "not authorized";
  return fmt::format("status {:04X}, {}", status, meaning);
}

}  // namespace angio::dicom::detail
