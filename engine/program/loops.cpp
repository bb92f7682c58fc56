// Components by Tarjan's algorithm; tears by the contractions of Levy and Low, A contraction algorithm for finding
// small cycle cutsets, J. Algorithms 9 (1988): exact where the contractions go through, else the busiest node is cut.

#include "engine/program/loops.h"

#include <algorithm>
#include <cassert>
#include <set>

namespace plantloop {

namespace {

constexpr std::uint32_t none = 0xffffffff;

bool is_condition(Op op) {
  switch (op) {
    case Op::less:
    case Op::less_equal:
    case Op::equal:
    case Op::logical_and:
    case Op::logical_or:
    case Op::logical_not:
      return true;
    default:
      return false;
  }
}

class Components {
 public:
  Components(const Record& record, bool initial)
      : record_(record),
        initial_(initial),
        number_(record.nodes.size(), none),
        low_(record.nodes.size(), 0),
        on_stack_(record.nodes.size(), false) {}

  // The components that hold a closed path, members ascending.
  std::vector<std::vector<std::uint32_t>> find() {
    for (std::uint32_t root = 0; root < record_.nodes.size(); ++root) {
      if (number_[root] == none) walk(root);
    }
    std::sort(found_.begin(), found_.end());
    return std::move(found_);
  }

 private:
  struct Visit {
    std::uint32_t node;
    std::vector<Value> operands;
    std::size_t next = 0;
  };

  void open(std::uint32_t node) {
    number_[node] = low_[node] = counter_++;
    on_stack_[node] = true;
    stack_.push_back(node);
    visits_.push_back({node, {}, 0});
    operands_of(record_, node, initial_, visits_.back().operands);
  }

  void walk(std::uint32_t root) {
    open(root);
    while (!visits_.empty()) {
      Visit& visit = visits_.back();
      if (visit.next == visit.operands.size()) {
        close();
        continue;
      }
      const Value operand = visit.operands[visit.next++];
      if (operand.is_known()) continue;
      const std::uint32_t id = operand.id();
      if (number_[id] == none) {
        open(id);
      } else if (on_stack_[id]) {
        low_[visit.node] = std::min(low_[visit.node], number_[id]);
      }
    }
  }

  void close() {
    const Visit visit = std::move(visits_.back());
    visits_.pop_back();
    if (!visits_.empty()) low_[visits_.back().node] = std::min(low_[visits_.back().node], low_[visit.node]);
    if (low_[visit.node] != number_[visit.node]) return;
    std::vector<std::uint32_t> members;
    for (std::uint32_t node = none; node != visit.node;) {
      node = stack_.back();
      stack_.pop_back();
      on_stack_[node] = false;
      members.push_back(node);
    }
    const bool closed = members.size() > 1 || std::any_of(visit.operands.begin(), visit.operands.end(), [&](Value v) {
                          return !v.is_known() && v.id() == visit.node;
                        });
    // A declared unknown whose equation does not contain it is a loop too: one without a solution.
    if (!closed && record_.nodes[visit.node].op != Op::implicit) return;
    std::sort(members.begin(), members.end());
    found_.push_back(std::move(members));
  }

  const Record& record_;
  bool initial_;
  std::vector<std::uint32_t> number_, low_;
  std::vector<bool> on_stack_;
  std::vector<std::uint32_t> stack_;
  std::vector<Visit> visits_;
  std::vector<std::vector<std::uint32_t>> found_;
  std::uint32_t counter_ = 0;
};

// Chooses the tears of one component.
class Tearing {
 public:
  Tearing(const Record& record, bool initial, const std::vector<bool>& is_signal, RecordedLoop& loop)
      : record_(record), loop_(loop), in_(loop.members.size()), out_(loop.members.size()) {
    std::vector<Value> operands;
    for (std::uint32_t i = 0; i < size(); ++i) {
      operands_of(record, loop.members[i], initial, operands);
      for (const Value v : operands) {
        const std::uint32_t j = v.is_known() ? none : place_of(v.id());
        if (j == none) continue;
        in_[i].insert(j);
        out_[j].insert(i);
      }
      const RecordedNode& node = record.nodes[loop.members[i]];
      const bool number = !is_compound(node.op) && node.op != Op::wire && !is_condition(node.op);
      may_be_cut_.push_back(number && (loop.rate == 0 || node.rate != 0));
      is_preferred_.push_back(may_be_cut_.back() && is_signal[loop.members[i]]);
    }
  }

  void run() {
    for (std::uint32_t i = 0; i < size(); ++i) {
      if (record_.nodes[loop_.members[i]].op == Op::implicit) cut(i);
    }
    const std::size_t declared = loop_.tears.size();
    while (contract() || cut_busiest()) continue;
    std::sort(loop_.tears.begin() + static_cast<std::ptrdiff_t>(declared), loop_.tears.end());
  }

 private:
  std::uint32_t size() const { return static_cast<std::uint32_t>(loop_.members.size()); }
  std::uint32_t place_of(std::uint32_t node) const {
    const auto at = std::lower_bound(loop_.members.begin(), loop_.members.end(), node);
    if (at == loop_.members.end() || *at != node) return none;
    return static_cast<std::uint32_t>(at - loop_.members.begin());
  }
  bool is_gone(std::uint32_t i) const { return in_[i].empty() && out_[i].empty(); }

  void remove(std::uint32_t i) {
    for (const auto j : in_[i]) out_[j].erase(i);
    for (const auto j : out_[i]) in_[j].erase(i);
    in_[i].clear();
    out_[i].clear();
  }

  void cut(std::uint32_t i) {
    loop_.tears.push_back(loop_.members[i]);
    remove(i);
  }

  void bypass(std::uint32_t i) {
    const std::set<std::uint32_t> from = in_[i], to = out_[i];
    remove(i);
    for (const auto a : from) {
      for (const auto b : to) {
        out_[a].insert(b);
        in_[b].insert(a);
      }
    }
  }

  // What lies on no closed path goes; what hands on from one to one only is bypassed. What cannot be cut goes first and
  // signals last, so that they remain to be cut.
  bool contract() {
    for (const int rank : {0, 1, 2}) {
      bool changed = false;
      for (std::uint32_t i = size(); i-- > 0;) {
        if (is_gone(i)) continue;
        if (in_[i].empty() || out_[i].empty()) {
          remove(i);
        } else if (in_[i].contains(i)) {
          if (may_be_cut_[i]) {
            cut(i);
          } else {
            loop_.problem = loop_.rate != 0 ? RecordedLoop::Problem::mixed_rates : RecordedLoop::Problem::no_number;
            remove(i);
          }
        } else if (rank_of(i) <= rank && (rank_of(i) == 0 || in_[i].size() == 1 || out_[i].size() == 1)) {
          bypass(i);
        } else {
          continue;
        }
        changed = true;
      }
      if (changed) return true;
    }
    return false;
  }
  int rank_of(std::uint32_t i) const { return !may_be_cut_[i] ? 0 : is_preferred_[i] ? 2 : 1; }

  bool cut_busiest() {
    std::uint32_t busiest = none;
    std::size_t most = 0;
    for (std::uint32_t i = 0; i < size(); ++i) {
      if (is_gone(i)) continue;
      const std::size_t busy = in_[i].size() * out_[i].size() * (is_preferred_[i] ? 2 : 1);
      if (busy > most) {
        most = busy;
        busiest = i;
      }
    }
    if (busiest == none) return false;
    cut(busiest);
    return true;
  }

  const Record& record_;
  RecordedLoop& loop_;
  std::vector<std::set<std::uint32_t>> in_, out_;
  std::vector<bool> may_be_cut_, is_preferred_;
};

// The shortest closed path through a member, from readers to drivers.
std::vector<std::uint32_t> cycle_through(const Record& record, bool initial, const RecordedLoop& loop,
                                         std::uint32_t start) {
  std::vector<std::uint32_t> reader(loop.members.size(), none), queue{start};
  const auto place = [&](std::uint32_t node) {
    const auto at = std::lower_bound(loop.members.begin(), loop.members.end(), node);
    return at == loop.members.end() || *at != node ? none : static_cast<std::uint32_t>(at - loop.members.begin());
  };
  std::vector<Value> operands;
  for (std::size_t head = 0; head < queue.size(); ++head) {
    operands_of(record, queue[head], initial, operands);
    for (const Value v : operands) {
      const std::uint32_t i = v.is_known() ? none : place(v.id());
      if (i == none || reader[i] != none) continue;
      reader[i] = queue[head];
      if (v.id() != start) {
        queue.push_back(v.id());
        continue;
      }
      std::vector<std::uint32_t> cycle;
      for (std::uint32_t at = reader[i]; at != start; at = reader[place(at)]) cycle.push_back(at);
      cycle.push_back(start);
      std::reverse(cycle.begin(), cycle.end());
      return cycle;
    }
  }
  return {start};
}

// Which rate the loop is solved at, and what about it cannot be.
void look_at_members(const Record& record, bool initial, RecordedLoop& loop) {
  for (const auto id : loop.members) {
    const RecordedNode& node = record.nodes[id];
    if (node.op == Op::wire) continue;
    const Value gate = record.activations[node.activation];
    const bool by_itself = node.activation != 0 && !gate.is_known() &&
                           std::binary_search(loop.members.begin(), loop.members.end(), gate.id());
    if (by_itself || record.rates[node.rate].triggered) loop.problem = RecordedLoop::Problem::conditional;
    if (initial) {
      const bool starts = node.op == Op::state || node.op == Op::discrete ||
                          (node.op == Op::kernel && record.kernels[node.a].kernel->starts_with_inputs() &&
                           !record.kernels[node.a].advance_inputs.empty());
      if (starts) loop.problem = RecordedLoop::Problem::initial_values;
      continue;
    }
    if (node.rate == 0) continue;
    if (loop.rate != 0 && loop.rate != node.rate) loop.problem = RecordedLoop::Problem::mixed_rates;
    loop.rate = node.rate;
  }
}

}  // namespace

void operands_of(const Record& record, std::uint32_t id, bool initial, std::vector<Value>& into) {
  const RecordedNode& node = record.nodes[id];
  into.clear();
  if (node.activation != 0 && !initial) into.push_back(record.activations[node.activation]);
  switch (node.op) {
    case Op::wire:
      into.push_back(record.wires[node.a]);
      return;
    case Op::implicit: {
      const RecordedUnknown& unknown = record.unknowns[node.a];
      into.assign({unknown.residual, unknown.lower, unknown.upper, unknown.guess});
      return;
    }
    case Op::state:
      if (initial) into.push_back(record.states[node.a].initial);
      return;
    case Op::discrete:
      if (initial) into.push_back(record.discretes[node.a].initial);
      return;
    case Op::kernel: {
      const KernelUse& use = record.kernels[node.a];
      for (const auto i : use.inputs) into.push_back(Value::node(i));
      if (initial && use.kernel->starts_with_inputs()) {
        for (const auto i : use.advance_inputs) into.push_back(Value::node(i));
      }
      return;
    }
    case Op::kernel_output:
      into.push_back(Value::node(node.a));
      return;
    default: {
      const int arity = arity_of(node.op);
      if (arity > 0) into.push_back(Value::node(node.a));
      if (arity > 1) into.push_back(Value::node(node.b));
      if (arity > 2) into.push_back(Value::node(node.c));
    }
  }
}

std::vector<RecordedLoop> find_loops(const Record& record, bool initial) {
  std::vector<RecordedLoop> loops;
  const auto components = Components(record, initial).find();
  if (components.empty()) return loops;
  std::vector<bool> is_signal(record.nodes.size(), false);
  for (const RecordedSignal& signal : record.signals) {
    if (!signal.value.is_known()) is_signal[signal.value.id()] = true;
  }
  for (const auto& members : components) {
    RecordedLoop loop;
    loop.members = members;
    look_at_members(record, initial, loop);
    Tearing(record, initial, is_signal, loop).run();
    loop.cycle = cycle_through(record, initial, loop, loop.tears.empty() ? members.front() : loop.tears.front());
    loops.push_back(std::move(loop));
  }
  return loops;
}

std::vector<std::uint32_t> sites_along(const Record& record, const std::vector<std::uint32_t>& cycle) {
  std::vector<std::uint32_t> sites;
  for (const auto id : cycle) {
    const std::uint32_t site = record.nodes[id].site;
    if (site == 0 || record.nodes[id].op == Op::wire) continue;  // a forward reference was made by its reader
    if (!sites.empty() && record.sites[sites.back()].path == record.sites[site].path) continue;
    sites.push_back(site);
  }
  while (sites.size() > 1 && record.sites[sites.front()].path == record.sites[sites.back()].path) sites.pop_back();
  // The walk went from readers to drivers; signals flow the other way.
  std::reverse(sites.begin(), sites.end());
  const auto first = std::min_element(sites.begin(), sites.end(),
                                      [&](auto a, auto b) { return record.sites[a].path < record.sites[b].path; });
  std::rotate(sites.begin(), first, sites.end());
  return sites;
}

std::string closed_path(const Record& record, const std::vector<std::uint32_t>& sites) {
  std::string text;
  for (const auto s : sites) text += record.sites[s].path + " -> ";
  return sites.empty() ? text : text + record.sites[sites.front()].path;
}

}  // namespace plantloop
