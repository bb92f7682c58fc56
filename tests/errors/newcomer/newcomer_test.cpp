// Every wrong diagram of this folder gives exactly the text beside it, and at least one finding with a place.

#include "engine/run/diagram.h"
#include "tests/errors/error_texts.h"

namespace plantloop {
namespace {

void check_all(const std::string& path, Report& report) {
  if (const auto diagram = Diagram::load(path, report); diagram) diagram->check({}, report);
  ASSERT_TRUE(report.has_errors()) << path << " is not wrong";
  for (const Finding& finding : report.findings()) {
    EXPECT_TRUE(finding.mark.source != nullptr && finding.mark.line > 0) << path << ": " << finding.message;
  }
}

PLANTLOOP_ERROR_TEXTS(NewcomerErrors, "tests/errors/newcomer", check_all);

}  // namespace
}  // namespace plantloop
