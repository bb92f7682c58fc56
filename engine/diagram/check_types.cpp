// Types that contain themselves, directly or through others.

#include <unordered_map>
#include <vector>

#include "engine/diagram/read.h"

namespace plantloop {
namespace {

class Containment {
 public:
  explicit Containment(Report& report) : report_(report) {}

  void visit(const TypeDecl& type) {
    if (!type.file || states_[&type] != State::fresh) return;
    states_[&type] = State::open;
    chain_.push_back(&type);
    for (const BlockDecl& block : type.blocks) {
      const auto inner = type.file->types.find(block.type);
      if (inner == type.file->types.end()) continue;
      if (states_[inner->second.get()] == State::open)
        report_chain(*inner->second, block);
      else
        visit(*inner->second);
    }
    chain_.pop_back();
    states_[&type] = State::done;
  }

 private:
  enum class State { fresh, open, done };

  void report_chain(const TypeDecl& type, const BlockDecl& block) {
    std::string text;
    bool inside = false;
    for (const TypeDecl* link : chain_) {
      inside = inside || link == &type;
      if (inside) text += fmt::format("{} -> ", link->name);
    }
    report_.error(block.type_mark, "the type '{}' contains itself: {}{}", type.name, text, type.name)
        .named("containment");
  }

  Report& report_;
  std::unordered_map<const TypeDecl*, State> states_;
  std::vector<const TypeDecl*> chain_;
};

}  // namespace

void check_containment(const Model& model, Report& report) {
  Containment containment(report);
  for (const auto& file : model.files) {
    for (const auto& [name, type] : file->types) containment.visit(*type);
  }
}

}  // namespace plantloop
