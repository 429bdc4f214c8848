#pragma once

#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmnet/scu.h>

#include <string>

#include "dicom/archive.hpp"

namespace angio::dicom::detail {

/// Our side of an association with an archive.
class Connection : public DcmSCU {
 public:
  explicit Connection(const ArchiveAddress& address);

  /// @param syntaxes  UIDs of transfer syntaxes, the best first
  void offer(const std::string& sop_class, const OFList<OFString>& syntaxes,
             T_ASC_SC_ROLE role = ASC_SC_ROLE_DEFAULT);
  /// @throws Error (69) saying why there is no association
  void connect();
  /// C-ECHO. @throws Error (69)
  void check_answers();
  /// The context under which the archive accepts a class. @throws Error (69) naming what it lacks
  T_ASC_PresentationContextID context_of(const std::string& sop_class, const std::string& what);
  void close() { releaseAssociation(); }
  /// @throws Error (69) if the archive did not answer
  void require(const OFCondition& condition, const std::string& what) const;

  [[nodiscard]] const std::string& name() const { return name_; }

 private:
  ArchiveAddress address_;
  std::string name_;  ///< "PACS at host:104"
};

/// Explicit, then implicit little endian.
OFList<OFString> uncompressed_syntaxes();

/// A DIMSE status in words (PS3.7 C).
std::string status_text(Uint16 status);

}  // namespace angio::dicom::detail
