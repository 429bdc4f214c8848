#pragma once

#include "viewer/report.hpp"

namespace angio::viewer::test {

/// A stenosed tube with one side branch, dilated: every part of a report is there.
ReportContent make_report_content();

}  // namespace angio::viewer::test
