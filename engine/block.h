// What a block is: a file that declares ports, parameters and states once, and writes its equations on symbolic Values.
//
// There is one object per block type; it never changes. Its methods run once for every instance in a diagram, when the
// diagram is compiled, and what they do is recorded. Everything that `now[...]` returns is an Array (a scalar, vector
// or matrix of Values) with element-wise arithmetic, so an elementary block works on vectors without a word about it.

#pragma once

#include <cstdint>
#include <functional>
#include <initializer_list>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/mark.h"
#include "engine/program/kernel.h"
#include "engine/program/value.h"

namespace plantloop {

class Block;
struct Count;

// The size of a port, parameter or state.
//   elementwise   the block's common size (the default): all of a block's elementwise things are scalars or vectors of
//   one size;
//                 a scalar input or parameter spreads
//   scalar        one number
//   any           a shape of its own, given by the parameter's value or the wire; outputs and states of it are set in
//   sizes() n             a vector of n elements, n a Count of the block or a number
struct Size {
  enum class Kind { elementwise, scalar, any, count, fixed };
  Kind kind = Kind::elementwise;
  int fixed = 1;
  const Count* count = nullptr;
  constexpr Size() = default;
  constexpr Size(Kind k) : kind(k) {}                               // NOLINT
  constexpr Size(int n) : kind(Kind::fixed), fixed(n) {}            // NOLINT
  constexpr Size(const Count& n) : kind(Kind::count), count(&n) {}  // NOLINT
};

inline constexpr double unbounded = std::numeric_limits<double>::infinity();
inline constexpr double required =
    std::numeric_limits<double>::quiet_NaN();  // as `init`: the diagram must give a value

// A thing that a block declares; `index` counts within its kind.
struct Declared {
  std::string_view name;
  int index = 0;
};

struct InputSpec {
  std::string_view doc = {};
  std::string_view unit = {};
  double init = required;  // the value of an unconnected input; a port with one may also be set like a parameter
  Size size = {};
};
struct Input : Declared {
  Input(Block* block, std::string_view name, InputSpec spec);
  InputSpec spec;
};
// A list port: the entries of a sequence stay apart.
struct Inputs : Declared {
  Inputs(Block* block, std::string_view name, InputSpec spec = {});
  InputSpec spec;
};

struct OutputSpec {
  std::string_view doc = {};
  std::string_view unit = {};
  Size size = {};
};
struct Output : Declared {
  Output(Block* block, std::string_view name, OutputSpec spec = {});
  OutputSpec spec;
};

// Numbers: tunable unless `structural`, so that a new value never recompiles.
struct NumberSpec {
  double init = required;
  std::string_view unit = {};
  std::string_view doc = {};
  double min = -unbounded;  // each element lies in [min, max]; `above` instead: greater than it
  double max = unbounded;
  double above = -unbounded;
  bool structural = false;
  Size size = {};
  bool optional = false;  // may be left out; given(number) tells
  bool initial = false;   // used in `initial` only: its expression may also read signals
};
struct Number : Declared {
  Number(Block* block, std::string_view name, NumberSpec spec = {});
  NumberSpec spec;
};
// A vector or matrix of its own size; entries are tunable but for their zeros, which are structural where
// `zeros_matter`.
struct TableSpec {
  std::string_view init = {};  // as written in a diagram, "[0, 1]"; empty: the diagram must give a value
  std::string_view unit = {};
  std::string_view doc = {};
  bool structural = false;
  bool zeros_matter = false;
  bool optional = false;
  bool ascending = false;  // strictly
  bool initial = false;    // as in NumberSpec
  double min = -unbounded;
  double max = unbounded;
  double above = -unbounded;
};
struct Table : Declared {
  Table(Block* block, std::string_view name, TableSpec spec = {});
  TableSpec spec;
};
// A whole number that the structure depends on; value() may be called while recording.
struct CountSpec {
  int init = 1;
  std::string_view doc = {};
  int min = 0;
  int max = 1000000;
};
struct Count : Declared {
  Count(Block* block, std::string_view name, CountSpec spec = {});
  int value() const;
  CountSpec spec;
};
// One of several words.
struct ChoiceSpec {
  std::initializer_list<std::string_view> of = {};  // the first one is the default
  std::string_view doc = {};
};
struct Choice : Declared {
  Choice(Block* block, std::string_view name, ChoiceSpec spec);
  std::string_view value() const;
  bool is(std::string_view word) const { return value() == word; }
  std::vector<std::string> words;
  std::string_view doc;
};
struct TextSpec {
  std::string_view init = {};
  std::string_view doc = {};
  bool file = false;  // a path inside the project: value() is resolved, and the file is known to be readable
  bool optional = false;
};
struct Text : Declared {
  Text(Block* block, std::string_view name, TextSpec spec = {});
  std::string value() const;
  TextSpec spec;
};

struct StateSpec {
  double init = 0;
  std::string_view unit = {};
  std::string_view doc = {};
  Size size = {};
};
// A continuous state.
struct State : Declared {
  State(Block* block, std::string_view name, StateSpec spec = {});
  StateSpec spec;
};
// A discrete state: update() sets its next value at the block's hits.
struct Discrete : Declared {
  Discrete(Block* block, std::string_view name, StateSpec spec = {});
  StateSpec spec;
};

// The instants of a source's discontinuities, as values that depend on parameters only.
// segment(times): how many of the ascending times are <= now. beats(first, period): how many instants first + k period,
// k >= 0, are <= now. The solver never steps over them.
Value segment(const Array& times);
Value beats(Value first, Value period);

// Values that equations determine: unknowns y with residual(y) = 0, one equation for each, found whenever they are
// read. The search begins at `guess` and stays between the bounds, which depend on parameters only; scalars spread.
struct Implicit {
  Array guess = Array(0.0);
  Array lower = Array(-unbounded);
  Array upper = Array(unbounded);
};
Array implicit(const Shape& shape, const Implicit& about, const std::function<Array(const Array&)>& residual);

// What is compared while one of these lives makes no events: for results that are smooth where the comparison changes.
class NoEvents {
 public:
  NoEvents();
  ~NoEvents();
  NoEvents(const NoEvents&) = delete;
  NoEvents& operator=(const NoEvents&) = delete;

 private:
  bool before_;
};

// Whether the conditional block that writes an entry of a list is active (of a triggered one: whether it runs at this
// instant), and since when, in s; the lowest number before the first time.
struct Activity {
  std::string path;  // of the block
  Truth active;
  Value since;
};

// How the hits of an input's signal lie to those of the sampled block that reads it.
enum class Meeting {
  never,   // the signal has none: it is continuous, or changes with parameters only
  faster,  // every hit of the block is one of the signal; equal rates, too
  slower,  // every hit of the signal is one of the block
  apart,   // neither
};

// What the equations read.
class Now {
 public:
  Array operator[](const Input& port) const;
  std::vector<Array> operator[](const Inputs& port) const;
  Array operator[](const Number& parameter) const;
  Array operator[](const Table& parameter) const;
  Array operator[](const State& state) const;
  Array operator[](const Discrete& state) const;
  Value time() const;                       // s
  Value hit() const;                        // discrete blocks: the number k of the present hit, from 0
  Value period() const;                     // discrete blocks: the time between hits in s
  bool connected(const Input& port) const;  // a wire, or a value given like a parameter
  Meeting meeting(const Input& port) const;
  // What an input was at an earlier hit of its own clock, `initial` until there was one: at the last one strictly
  // before the block's present hit or, `steady`, at the one before the signal's latest, as long as that is the latest.
  Array earlier(const Input& port, const Array& initial, bool steady) const;
  std::string path() const;      // of the block: "plant.valve", for messages of kernels
  std::uint64_t stream() const;  // a number of the block's own, from its path: for random streams
  std::vector<Activity> activity(const Inputs& port) const;  // by entry
  bool given(const Number& parameter) const;
  bool given(const Table& parameter) const;
  // The outputs of a kernel fed by `inputs` at the same instant; `advanced` are read by its advance only.
  std::vector<Value> kernel(std::shared_ptr<const Kernel> kernel, std::vector<Value> inputs,
                            std::vector<Value> advanced = {}) const;
};

// What the equations write: out[y] = value, rate[x] = value, next[xd] = value, init[x] = value. A scalar spreads to the
// shape.
enum class Written { output, derivative, next, initial_state, initial_discrete };
class Target {
 public:
  Target(Written what, int index) : what_(what), index_(index) {}
  void operator=(const Array& value) const;
  void operator=(Value value) const { *this = Array(value); }
  void operator=(double value) const { *this = Array(value); }

 private:
  Written what_;
  int index_;
};
struct Out {
  Target operator[](const Output& port) const { return {Written::output, port.index}; }
};
struct Rates {
  Target operator[](const State& state) const { return {Written::derivative, state.index}; }
};
struct Next {
  Target operator[](const Discrete& state) const { return {Written::next, state.index}; }
};
struct Init {
  Target operator[](const State& state) const { return {Written::initial_state, state.index}; }
  Target operator[](const Discrete& state) const { return {Written::initial_discrete, state.index}; }
};

enum class Direction { rising, falling, either };
struct Crossing {
  Array function;  // crosses zero at the event
  Direction direction;
  bool of_slope = false;  // it is the function's derivative by time that crosses zero
  // Where a kernel's output is not smooth, which the kernel tells by itself: a step ends there, and nothing else
  // happens; it is not among the events that a run records.
  bool of_kernel = false;
  bool level = false;     // it also fires where the function is positive when it begins to be looked at
  std::string name = {};  // of the event, behind the block's path; "": "jump"
};
inline Crossing crossing(const Array& function, Direction direction = Direction::either) {
  return {function, direction};
}
// The instant at which a condition becomes true; one that holds at the start does not. What the event sets is computed
// from the states just before and the conditions just after it.
inline Crossing becomes(const Truths& condition) { return {where(condition, 0.5, -0.5), Direction::rising}; }
// The instant at which a continuous signal turns: from rising to falling (`falling`), or the other way round. The slope
// is computed along the run, from the equations; what passes through a kernel is not seen.
inline Crossing turning(const Array& signal, Direction direction = Direction::either) {
  return {signal, direction, true};
}
// jumps(): at the event that `when` names, the states get new values, computed from the values just before it. The
// crossing and the values go element by element. An event that sets nothing is a step's end and no more.
class Jumps {
 public:
  class Event {
   public:
    explicit Event(int index) : index_(index) {}
    const Event& set(const State& state, const Array& value) const;
    const Event& set(const Discrete& state, const Array& value) const;

   private:
    int index_;
  };
  Event when(const Crossing& crossing) const;
};

// Sizes known so far, for sizes(); unknown shapes are skipped, the method is called again until nothing changes.
class Sizing {
 public:
  virtual ~Sizing() = default;
  virtual Shape of(const Input& port) const = 0;
  virtual std::vector<Shape> of(const Inputs& port) const = 0;
  virtual Shape of(const Table& parameter) const = 0;
  virtual Shape of(const Number& parameter) const = 0;
  virtual Shape of(const Output& port) const = 0;
  virtual Shape of(const State& state) const = 0;
  // The numbers of a structural parameter; empty while they are not known.
  virtual std::vector<double> numbers(const Table& parameter) const = 0;
  // States what a shape is. A second, different shape is a finding that names both.
  virtual void set(const Output& port, Shape shape) = 0;
  virtual void set(const State& state, Shape shape) = 0;
  virtual void set(const Discrete& state, Shape shape) = 0;
  // What an input must be; a wire of another shape is a finding (a scalar spreads).
  virtual void expect(const Input& port, Shape shape) = 0;
  // A finding about a parameter, e.g. expect_shape(B, ...): "B has 2 rows, A has 3".
  virtual void problem(const Declared& parameter, const std::string& text) = 0;
};

// Facts about parameter values that bounds cannot say, checked at each setting with numbers.
class Checking {
 public:
  virtual ~Checking() = default;
  virtual std::vector<double> of(const Number& parameter) const = 0;
  virtual std::vector<double> of(const Table& parameter) const = 0;
  virtual Shape shape(const Table& parameter) const = 0;
  virtual bool given(const Declared& parameter) const = 0;
  virtual void problem(const Declared& parameter, const std::string& text) = 0;
  // What is right but should be known; `check` is the name of the check.
  virtual void note(const Declared& parameter, std::string_view check, const std::string& text) = 0;
};

// Which rates a block may run at.
enum class RateKind {
  any,         // inherited: stateless blocks
  continuous,  // has continuous states, or means nothing else
  discrete,    // has discrete states: needs a rate
  source,      // no inputs: continuous unless all its readers are of one discrete rate
  watching,    // as `any`, but continuous when nothing that it reads ever changes: it watches the time
};

class Block {
 public:
  // For `.size =` in declarations.
  static constexpr Size::Kind elementwise = Size::Kind::elementwise;
  static constexpr Size::Kind scalar = Size::Kind::scalar;
  static constexpr Size::Kind any_size = Size::Kind::any;

  Block() = default;
  Block(const Block&) = delete;
  Block& operator=(const Block&) = delete;
  virtual ~Block() = default;

  virtual void sizes(Sizing& sizing) const { (void)sizing; }
  virtual void check(Checking& checking) const { (void)checking; }
  virtual void initial(Now now, Init init) const {
    (void)now, (void)init;
  }  // a state not set here starts at its spec's init
  virtual void outputs(Now now, Out out) const { (void)now, (void)out; }
  virtual void derivatives(Now now, Rates rate) const { (void)now, (void)rate; }
  virtual void update(Now now, Next next) const { (void)now, (void)next; }
  virtual void jumps(Now now, Jumps jump) const { (void)now, (void)jump; }
  // A period in s, exact as decimal text, that the instance brings along, as from a file; "": none. It may read texts.
  virtual std::string own_period() const { return {}; }
  virtual RateKind rate_kind() const;  // from the declared states and inputs unless overridden

  // The declarations, in order.
  std::vector<const Input*> inputs;
  std::vector<const Inputs*> lists;  // at most one, and then it is the only port
  std::vector<const Output*> outputs_declared;
  std::vector<const Number*> numbers;
  std::vector<const Table*> tables;
  std::vector<const Count*> counts;
  std::vector<const Choice*> choices;
  std::vector<const Text*> texts;
  std::vector<const State*> states;
  std::vector<const Discrete*> discretes;
  // Names of everything that a diagram may set, in order of declaration.
  std::vector<std::string_view> settable;
};

// A block type as the catalogue lists it.
struct BlockType {
  std::string_view name;
  std::string_view group;  // the folder below blocks/
  std::string_view summary;
  std::string_view details;
  // A whole diagram but for its first line, `plantloop: 1`, that meets its `expect:`; empty when the block shows none.
  std::string_view example;
  std::unique_ptr<const Block> block;
  std::string_view icon;  // empty: the drawing finds a face for it
  // Of a block that is written in a form of its own: what stands behind `type:` in a small instance that reads a
  // signal `a`. Its declared texts are keys whose values need not be texts.
  std::string_view written;
};

// What a drawing shows on a block's face, when its class says so: `static constexpr auto icon = "k/(tau*s + 1)"`, an
// expression over its parameters and s or z, in which a table stands for a polynomial.
template <typename Class>
constexpr std::string_view icon_of() {
  if constexpr (requires { Class::icon; }) {
    return Class::icon;
  } else {
    return {};
  }
}

template <typename Class>
constexpr std::string_view written_of() {
  if constexpr (requires { Class::written; }) {
    return Class::written;
  } else {
    return {};
  }
}

// All block types, sorted by name; made by CMake from the file names under blocks/.
const std::vector<BlockType>& catalogue();
// The type of that name, or null.
const BlockType* find_block(std::string_view name);

// The block's `example` without the line end that a raw string begins with, where it has one.
template <typename Class>
constexpr std::string_view example_of() {
  if constexpr (requires { Class::example; }) {
    return std::string_view(Class::example).substr(1);
  } else {
    return {};
  }
}

// Registers the block of a file. Its name is the file's name.
#define PLANTLOOP_BLOCK(type_name, Class)                                  \
  BlockType plantloop_block_##type_name() {                                \
    return BlockType{#type_name,          {},                              \
                     Class::summary,      Class::details,                  \
                     example_of<Class>(), std::make_unique<const Class>(), \
                     icon_of<Class>(),    written_of<Class>()};            \
  }

}  // namespace plantloop
