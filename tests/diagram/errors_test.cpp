// Every wrong diagram of tests/errors/diagram gives exactly the text beside it.

#include "engine/diagram/model.h"
#include "tests/errors/error_texts.h"

namespace plantloop {
namespace {

PLANTLOOP_ERROR_TEXTS(DiagramErrors, "tests/errors/diagram",
                      [](const std::string& path, Report& report) { read_model(path, report); });

}  // namespace
}  // namespace plantloop
