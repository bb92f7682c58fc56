// plantloop blocks: which block types there are, and what each one takes and does.

#include <fmt/format.h>

#include <memory>

#include "app/command.h"
#include "engine/block.h"
#include "engine/graph/describe.h"

PLANTLOOP_COMMAND(blocks) {
  using namespace plantloop;
  using namespace plantloop::app;
  struct Options {
    std::string type;
    bool markdown = false;
  };
  const auto o = std::make_shared<Options>();
  parser.description("List the block types, or tell everything about one.");
  parser.add_option("TYPE", o->type, "a block type");
  parser.add_flag("--markdown", o->markdown, "as a page of documentation");
  parser.footer("Examples:\n  plantloop blocks\n  plantloop blocks integrator");
  return [o] {
    if (!o->type.empty()) {
      const BlockType* type = find_block(o->type);
      if (type == nullptr) {
        std::vector<std::string> names;
        for (const BlockType& t : catalogue()) names.emplace_back(t.name);
        const std::string near = nearest(o->type, names);
        complain(fmt::format("there is no block type '{}'{}", o->type,
                             near.empty() ? "; see: plantloop blocks" : fmt::format("; did you mean '{}'?", near)));
        return input_wrong;
      }
      return write_out(o->markdown ? block_markdown(*type) : block_text(*type)) ? done : run_failed;
    }
    return write_out(o->markdown ? catalogue_markdown() : catalogue_text()) ? done : run_failed;
  };
}
