// plantloop test: runs diagrams and holds them to their `expect:` sections.

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>

#include "app/command.h"
#include "app/difference.h"
#include "app/draw.h"
#include "app/figures.h"
#include "app/junit.h"
#include "app/request.h"
#include "engine/base/error.h"
#include "engine/base/files.h"

namespace plantloop::app {

namespace {

struct TestOptions {
  std::vector<std::string> paths;
  std::string junit, figures = "out";
  double max_time = 0;
  bool strict = false;
};

double seconds() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

// A folder holds other YAML, too: only files that say which format they have are meant.
bool looks_like_a_diagram(const std::string& path) {
  const FileResult file = read_file(path);
  if (!file.ok()) return false;
  return file.value.rfind("plantloop:", 0) == 0 || file.value.find("\nplantloop:") != std::string::npos;
}

// The diagrams of the arguments, folders with all that is below them, in order of their names. Nothing after
// complaining.
std::optional<std::vector<std::string>> find_diagrams(const std::vector<std::string>& paths) {
  std::vector<std::string> files;
  for (const std::string& path : paths) {
    std::error_code failed;
    if (!std::filesystem::exists(path, failed)) {
      complain(fmt::format("there is no file or folder '{}'", path));
      return std::nullopt;
    }
    if (!std::filesystem::is_directory(path, failed)) {
      files.push_back(path);
      continue;
    }
    std::vector<std::string> inside;
    for (auto it = std::filesystem::recursive_directory_iterator(path, failed);
         it != std::filesystem::recursive_directory_iterator(); it.increment(failed)) {
      if (failed) break;
      if (it->is_directory() && it->path().filename().string().front() == '.') it.disable_recursion_pending();
      if (it->is_regular_file() && it->path().extension() == ".yaml" && looks_like_a_diagram(it->path().string()))
        inside.push_back(it->path().string());
    }
    std::sort(inside.begin(), inside.end());
    files.insert(files.end(), inside.begin(), inside.end());
  }
  return files;
}

// "diagrams/car.yaml", 3 -> "out/diagrams-car.expect3.png"
std::string figure_path(const std::string& folder, const std::string& diagram, std::size_t entry) {
  std::string name = std::filesystem::path(diagram).lexically_normal().replace_extension().string();
  std::replace(name.begin(), name.end(), '/', '-');
  name.erase(0, name.find_first_not_of(".-"));
  return fmt::format("{}/{}.expect{}.png", folder, name, entry + 1);
}

class Tester {
 public:
  explicit Tester(const TestOptions& options) : options_(options) {}

  // Prints what happens; the exit status.
  int run(const std::vector<std::string>& files) {
    for (const std::string& file : files) test(file);
    std::size_t cases = 0, failed = 0, broken = 0;
    for (const TestSuite& suite : suites_) {
      for (const TestCase& c : suite.cases) {
        (c.outcome == TestCase::error ? broken : cases) += 1;
        failed += c.outcome == TestCase::failed ? 1 : 0;
      }
    }
    if (suites_.empty()) {
      complain("no diagram with an 'expect:' section was found");
      return input_wrong;
    }
    const auto counted = [](std::size_t n, const char* what) {
      return fmt::format("{} {}{}", n, what, n == 1 ? "" : "s");
    };
    std::string sum = counted(suites_.size(), "diagram");
    if (broken > 0) sum += fmt::format(", {} did not run", broken);
    if (cases > 0)
      sum += fmt::format(", {}, {}", counted(cases, "expectation"),
                         failed == 0 ? "all met" : fmt::format("{} not met", failed));
    write_out(sum + "\n");
    if (!options_.junit.empty() && !write_result(options_.junit, to_junit(suites_))) return run_failed;
    return wrong_ ? input_wrong : failed + broken > 0 ? run_failed : done;
  }

 private:
  void test(const std::string& file) {
    const double start = seconds();
    Report report;
    if (options_.strict) report.make_strict();
    const auto diagram = Diagram::load(file, report, plot_words());
    const bool nothing_to_test =
        diagram && !report.has_errors() && (diagram->model().is_library || diagram->model().expect.empty());
    if (nothing_to_test) {
      write_out(fmt::format("-      {}  nothing expected\n", file));
      return;
    }
    TestSuite suite;
    suite.name = file;
    std::optional<DiagramRun> run;
    std::string error;
    try {
      if (diagram && !report.has_errors()) {
        RunControl control;
        control.cancel = &interrupted;
        control.time_limit = options_.max_time;
        run = diagram->run({}, report, control);
      }
    } catch (const RunError& e) {
      error = e.what();
    }
    if (!run && error.empty()) wrong_ = true;
    suite.seconds = seconds() - start;
    if (!run) {
      if (error.empty()) error = to_text(report);
      suite.cases.push_back({"runs", TestCase::error, error, {}, 0});
      write_out(fmt::format("ERROR  {}\n{}\n", file, error));
    } else {
      judge(*diagram, *run, suite);
      if (report.has_errors()) {  // of what was noticed during the run
        const std::string text = to_text(report);
        suite.cases.push_back({"checks", TestCase::failed, text, {}, 0});
        write_out(fmt::format("FAILED {}  checks\n{}", file, text));
      }
    }
    suites_.push_back(std::move(suite));
  }

  void judge(const Diagram& diagram, const DiagramRun& run, TestSuite& suite) {
    std::string text;
    std::size_t failed = 0;
    for (std::size_t i = 0; i < run.verdicts.size(); ++i) {
      const Verdict& v = run.verdicts[i];
      TestCase one{v.text, v.met ? TestCase::passed : TestCase::failed, v.measured, diagram.model().path, v.mark.line};
      if (!v.met) {
        ++failed;
        text += fmt::format("  {}:{}: {}\n    {}\n", diagram.model().path, v.mark.line, v.text, v.measured);
        text += draw(diagram, run, i);
      }
      suite.cases.push_back(std::move(one));
    }
    write_out(fmt::format("{} {}  {} of {} met, {:.2f} s\n{}", failed == 0 ? "ok    " : "FAILED", suite.name,
                          run.verdicts.size() - failed, run.verdicts.size(), suite.seconds, text));
  }

  std::string draw(const Diagram& diagram, const DiagramRun& run, std::size_t entry) const {
    if (options_.figures.empty()) return {};
    const Figure figure = figure_of(run.verdicts[entry], run, diagram.model());
    if (figure.panels.empty()) return {};
    const std::string path = figure_path(options_.figures, diagram.model().path, entry);
    const std::string error = write_figure(figure, path);
    if (error.empty()) return fmt::format("    drawn in {}\n", path);
    complain(error);
    return {};
  }

  const TestOptions& options_;
  std::vector<TestSuite> suites_;
  bool wrong_ = false;  // the input
};

int test(const TestOptions& o) {
  const auto files = find_diagrams(o.paths);
  return files ? Tester(o).run(*files) : input_wrong;
}

}  // namespace

}  // namespace plantloop::app

PLANTLOOP_COMMAND(test) {
  using namespace plantloop::app;
  const auto o = std::make_shared<TestOptions>();
  parser.description("Run diagrams and hold them to their expect: sections and baselines.");
  parser.add_option("PATH", o->paths, "diagrams, or folders with diagrams in them")->required();
  parser.add_option("--junit", o->junit, "write the verdicts as JUnit XML, for continuous integration")
      ->type_name("FILE");
  parser.add_option("--figures", o->figures, "folder for a picture of each expectation that is not met; \"\" for none")
      ->type_name("DIR")
      ->capture_default_str();
  add_strict_option(parser, o->strict);
  parser.add_option("--max-time", o->max_time, "end a run after this many seconds")->check(CLI::PositiveNumber);
  parser.footer(
      "Exit status 0 when all is met, 1 when something is not or a run failed, 2 when a diagram is wrong.\n\n"
      "Examples:\n"
      "  plantloop test diagrams\n"
      "  plantloop test loop.yaml car.yaml --junit report.xml");
  return [o] { return test(*o); };
}
