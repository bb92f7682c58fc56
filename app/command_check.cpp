// plantloop check: everything but running.

#include <fmt/format.h>

#include <memory>

#include "app/command.h"
#include "app/figures.h"
#include "app/request.h"
#include "engine/run/diagram.h"

PLANTLOOP_COMMAND(check) {
  using namespace plantloop;
  using namespace plantloop::app;
  struct Options {
    std::vector<std::string> files;
    std::string format = "text";
    bool strict = false, list = false;
  };
  const auto o = std::make_shared<Options>();
  parser.description("Find everything that is wrong with diagrams, without running them.");
  parser.add_option("FILE", o->files, "diagrams or libraries of types");
  parser
      .add_option("--format", o->format,
                  "how findings are printed: text (to standard error), json or sarif (to standard output)")
      ->check(CLI::IsMember({"text", "json", "sarif"}))
      ->capture_default_str();
  add_strict_option(parser, o->strict);
  parser.add_flag("--list", o->list, "print the checks whose severity a diagram may change under checks:, in Markdown");
  parser.footer(
      "Exit status 0 when nothing is wrong, 2 when something is.\n\n"
      "Examples:\n"
      "  plantloop check loop.yaml\n"
      "  plantloop check diagrams/*.yaml --format sarif > findings.sarif");
  return [o] {
    if (o->list) return write_out(checks_markdown()) ? done : run_failed;
    if (o->files.empty()) {
      complain("check: name at least one file");
      return input_wrong;
    }
    Report report;
    bool wrong = false;
    for (const std::string& file : o->files) {
      // One file's findings do not hide another's: each has room for twenty.
      Report own;
      if (o->strict) own.make_strict();
      if (const auto diagram = Diagram::load(file, own, plot_words())) {
        diagram->check({}, own);
      }
      wrong = wrong || own.has_errors();
      if (o->format == "text") {
        print(own);
        if (!own.has_errors() && is_terminal(1)) fmt::print("{}: nothing wrong\n", file);
      } else {
        report.append(std::move(own));
      }
    }
    if (o->format == "json" && !write_out(to_json(report))) return run_failed;
    if (o->format == "sarif" && !write_out(to_sarif(report))) return run_failed;
    return wrong ? input_wrong : done;
  };
}
