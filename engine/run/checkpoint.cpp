// Checkpoints are JSON: names and numbers that a person can read, and that come back to the last bit.

#include "engine/run/checkpoint.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <type_traits>

namespace plantloop {

namespace {

using Json = nlohmann::json;
constexpr int format_version = 3;

// Numbers that are no JSON numbers are texts.
Json in_json(double v) {
  if (std::isnan(v)) return "nan";
  if (std::isinf(v)) return v > 0 ? "inf" : "-inf";
  return v;
}
double number(const Json& j) {
  if (j.is_string()) {
    const auto& text = j.get_ref<const std::string&>();
    if (text == "nan") return std::numeric_limits<double>::quiet_NaN();
    if (text == "inf") return std::numeric_limits<double>::infinity();
    if (text == "-inf") return -std::numeric_limits<double>::infinity();
  }
  return j.get<double>();
}

Json in_json(const std::vector<double>& values) {
  Json list = Json::array();
  for (const double v : values) list.push_back(in_json(v));
  return list;
}
std::vector<double> numbers(const Json& list) {
  std::vector<double> values;
  for (const Json& j : list) values.push_back(number(j));
  return values;
}

Json in_json(const std::map<std::string, double>& values) {
  Json object = Json::object();
  for (const auto& [name, v] : values) object[name] = in_json(v);
  return object;
}
std::map<std::string, double> named_numbers(const Json& object) {
  std::map<std::string, double> values;
  for (const auto& [name, v] : object.items()) values[name] = number(v);
  return values;
}

class Hash {
 public:
  void add(std::string_view text) {
    for (const char c : text) byte(static_cast<unsigned char>(c));
    byte(0xff);
  }
  template <typename Integer>
  void add(const std::vector<Integer>& values) {
    number(values.size());
    for (const auto v : values) number(static_cast<std::uint64_t>(v));
  }
  void number(std::uint64_t v) {
    for (int i = 0; i < 8; ++i) byte(static_cast<unsigned char>(v >> (8 * i)));
  }
  std::uint64_t value() const { return value_; }

 private:
  void byte(unsigned char b) { value_ = (value_ ^ b) * 1099511628211u; }  // FNV-1a
  std::uint64_t value_ = 14695981039346656037u;
};

// Of everything else: a number that was changed by chance or by hand must not become a result.
std::uint64_t checksum_of(Json json) {
  json.erase("checksum");
  Hash hash;
  hash.add(json.dump());
  return hash.value();
}

}  // namespace

std::uint64_t structure_of(const Program& program) {
  Hash hash;
  for (const std::string& name : program.state_names) hash.add(name);
  for (const std::string& name : program.discrete_names) hash.add(name);
  for (const RecordedParameter& p : program.parameter_info) hash.add(p.name);
  for (const RecordedRate& rate : program.rates) hash.add(rate.period.to_string() + "+" + rate.offset.to_string());
  for (const Program::Jump& jump : program.jumps) hash.add(jump.name);
  for (const Program::KernelState& kernel : program.kernels) hash.add(kernel.kernel->name());
  hash.add(program.parameters), hash.add(program.discretes), hash.add(program.modes), hash.add(program.segments);
  hash.number(program.arena.size()), hash.number(program.states), hash.number(program.time);
  hash.number(program.guards.size()), hash.number(program.kernel_state_size), hash.number(program.history_count);
  for (const List* list : {&program.derivative_list, &program.held_list, &program.mode_list, &program.guard_list}) {
    hash.add(list->roots);
    hash.number(list->operation_count);
  }
  return hash.value();
}

void save(const Frame& frame, Checkpoint& c) {
  const Program& program = *frame.program;
  c.structure = structure_of(program);
  c.arena.assign(frame.arena, frame.arena + program.arena.size());
  c.kernel_states = frame.kernel_states;
  c.loop_values = frame.loop_values;
  c.histories = frame.histories;
  c.next_hit = frame.next_hit;
  c.next_instant = frame.next_instant;
  for (std::size_t i = 0; i < program.state_names.size(); ++i)
    c.states[program.state_names[i]] = frame.arena[program.states + i];
  for (std::size_t i = 0; i < program.discretes.size(); ++i)
    c.sampled[program.discrete_names[i]] = frame.arena[program.discretes[i]];
}

void restore(const Checkpoint& c, Frame& frame) {
  const Program& program = *frame.program;
  std::vector<double> parameters;
  for (const auto slot : program.parameters) parameters.push_back(frame.arena[slot]);
  std::copy(c.arena.begin(), c.arena.end(), frame.arena);
  for (std::size_t p = 0; p < parameters.size(); ++p) frame.set_parameter(p, parameters[p]);
  execute(program.parameter_list, frame.arena);
  frame.kernel_states = c.kernel_states;
  frame.loop_values = c.loop_values;
  frame.histories = c.histories;
  frame.next_hit = c.next_hit;
  frame.next_instant = c.next_instant;
}

void restore_by_path(const Checkpoint& c, Frame& frame) {
  const Program& program = *frame.program;
  for (std::size_t i = 0; i < program.state_names.size(); ++i) {
    const auto found = c.states.find(program.state_names[i]);
    if (found != c.states.end()) frame.states()[i] = found->second;
  }
  for (std::size_t i = 0; i < program.discretes.size(); ++i) {
    const auto found = c.sampled.find(program.discrete_names[i]);
    if (found != c.sampled.end()) frame.arena[program.discretes[i]] = found->second;
  }
}

std::vector<std::string> missing_in(const Checkpoint& c, const Program& program) {
  std::vector<std::string> missing;
  for (const std::string& name : program.state_names) {
    if (!c.states.contains(name)) missing.push_back(name);
  }
  for (const std::string& name : program.discrete_names) {
    if (!c.sampled.contains(name)) missing.push_back(name);
  }
  return missing;
}

std::vector<std::string> extra_in(const Checkpoint& c, const Program& program) {
  std::vector<std::string> extra;
  const auto look = [&](const std::map<std::string, double>& saved, const std::vector<std::string>& names) {
    for (const auto& [name, value] : saved) {
      if (std::find(names.begin(), names.end(), name) == names.end()) extra.push_back(name);
    }
  };
  look(c.states, program.state_names);
  look(c.sampled, program.discrete_names);
  return extra;
}

std::string to_json(const Checkpoint& c) {
  Json histories = Json::array();
  for (const History& h : c.histories)
    histories.push_back({{"time", in_json(h.time)}, {"value", in_json(h.value)}, {"order", in_json(h.order)}});
  std::vector<int> signs(c.signs.begin(), c.signs.end());
  Json json = {{"plantloop_checkpoint", format_version},
               {"start", in_json(c.start)},
               {"time", in_json(c.time)},
               {"structure", c.structure},
               {"states", in_json(c.states)},
               {"sampled", in_json(c.sampled)},
               {"arena", in_json(c.arena)},
               {"kernels", in_json(c.kernel_states)},
               {"loops", in_json(c.loop_values)},
               {"histories", histories},
               {"next_hit", c.next_hit},
               {"next_instant", c.next_instant},
               {"signs", signs},
               {"at_zero", c.at_zero},
               {"was_open", std::vector<int>(c.was_open.begin(), c.was_open.end())},
               {"last_event", in_json(c.last_event)},
               {"quiet_until", in_json(c.quiet_until)},
               {"in_a_row", c.in_a_row},
               {"sign_when_muted", std::vector<int>(c.sign_when_muted.begin(), c.sign_when_muted.end())},
               {"still", c.still}};
  json["checksum"] = checksum_of(json);
  return json.dump(1) + "\n";
}

CheckpointResult checkpoint_from_json(std::string_view text) {
  CheckpointResult result;
  const Json json = Json::parse(text.begin(), text.end(), nullptr, false);
  if (!json.is_object() || !json.contains("plantloop_checkpoint")) {
    result.error = "it is no checkpoint of a run";
    return result;
  }
  try {
    if (json.at("plantloop_checkpoint").get<int>() != format_version) {
      result.error = fmt::format("it was written by another version: its format is {}, this one reads {}",
                                 json.at("plantloop_checkpoint").get<int>(), format_version);
      return result;
    }
    if (json.at("checksum").get<std::uint64_t>() != checksum_of(json)) {
      result.error = "it is damaged: its checksum is of other contents";
      return result;
    }
    Checkpoint& c = result.checkpoint;
    c.start = number(json.at("start"));
    c.time = number(json.at("time"));
    c.structure = json.at("structure").get<std::uint64_t>();
    c.states = named_numbers(json.at("states"));
    c.sampled = named_numbers(json.at("sampled"));
    c.arena = numbers(json.at("arena"));
    c.kernel_states = numbers(json.at("kernels"));
    c.loop_values = numbers(json.at("loops"));
    for (const Json& h : json.at("histories")) {
      History history;
      history.time = numbers(h.at("time"));
      history.value = numbers(h.at("value"));
      history.order = numbers(h.at("order"));
      c.histories.push_back(std::move(history));
    }
    c.next_hit = json.at("next_hit").get<std::vector<std::int64_t>>();
    c.next_instant = json.at("next_instant").get<std::vector<std::int64_t>>();
    for (const int sign : json.at("signs").get<std::vector<int>>()) c.signs.push_back(static_cast<std::int8_t>(sign));
    c.at_zero = json.at("at_zero").get<std::vector<bool>>();
    for (const int open : json.at("was_open").get<std::vector<int>>())
      c.was_open.push_back(static_cast<std::uint8_t>(open));
    c.last_event = numbers(json.at("last_event"));
    c.quiet_until = numbers(json.at("quiet_until"));
    c.in_a_row = json.at("in_a_row").get<std::vector<int>>();
    for (const int sign : json.at("sign_when_muted").get<std::vector<int>>())
      c.sign_when_muted.push_back(static_cast<std::int8_t>(sign));
    c.still = json.at("still").get<std::vector<std::uint32_t>>();
  } catch (const Json::exception&) {
    result.error = "it is damaged: a part of the checkpoint is missing or of another kind";
  }
  return result;
}

}  // namespace plantloop
