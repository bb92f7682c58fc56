// Every wrong diagram of tests/errors/graph gives exactly the text beside it.

#include "engine/diagram/model.h"
#include "engine/graph/graph.h"
#include "tests/errors/error_texts.h"

namespace plantloop {
namespace {

PLANTLOOP_ERROR_TEXTS(GraphErrors, "tests/errors/graph",
                      [](const std::string& path, Report& report) { elaborate(read_model(path, report), {}, report); });

}  // namespace
}  // namespace plantloop
