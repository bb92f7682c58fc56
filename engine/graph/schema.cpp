// The JSON schema of diagram files: what editors complete and check.

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <vector>

#include "engine/base/numbers.h"
#include "engine/graph/describe.h"

namespace plantloop {
namespace {

std::string quoted(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (c == '\n') {
      out += "\\n";
    } else if (static_cast<unsigned char>(c) < 0x20) {
      out += fmt::format("\\u{:04x}", static_cast<int>(c));
    } else {
      out += c;
    }
  }
  return out + "\"";
}

// An object in the making: members in order.
class Object {
 public:
  Object& add(std::string_view key, const std::string& json) {
    members_ += (members_.empty() ? "" : ",") + quoted(key) + ":" + json;
    return *this;
  }
  std::string text() const { return "{" + members_ + "}"; }

 private:
  std::string members_;
};

std::string reference(std::string_view name) {
  return Object().add("$ref", quoted(fmt::format("#/$defs/{}", name))).text();
}

std::string described(std::string_view name, const std::string& doc) {
  return Object().add("$ref", quoted(fmt::format("#/$defs/{}", name))).add("description", quoted(doc)).text();
}

std::string with_unit(std::string_view doc, std::string_view unit, const std::string& standard) {
  std::string text(doc);
  if (!unit.empty()) text += fmt::format(" [{}]", unit);
  if (!standard.empty()) text += fmt::format("; default {}", standard);
  return text;
}

std::string of_strings(const std::vector<std::string>& words) {
  std::string list;
  for (const std::string& word : words) list += (list.empty() ? "" : ",") + quoted(word);
  return "[" + list + "]";
}

// The values of keys that a block writes in a form of its own; "" for others.
std::string form_of(const BlockType& type, std::string_view key) {
  if (type.name != "state_machine") return {};
  if (key == "states") {
    return R"({"type":"object","minProperties":1,"additionalProperties":{"type":["object","null"],"properties":{"set":)"
           R"({"type":"object","additionalProperties":{"$ref":"#/$defs/expression"}}},"additionalProperties":false},)"
           R"("description":"names, with the outputs that are set in each"})";
  }
  if (key == "transitions") {
    return R"({"type":"array","items":{"type":"object","properties":{"from":{"type":"string"},"to":{"type":"string"},)"
           R"("when":{"$ref":"#/$defs/expression"}},"required":["from","to","when"],"additionalProperties":false},)"
           R"("description":"by falling priority"})";
  }
  return {};
}

std::string definition_of(const BlockType& type) {
  const Block& block = *type.block;
  Object properties;
  properties.add("type", Object().add("const", quoted(type.name)).text());
  for (const Input* input : block.inputs) {
    if (input->spec.init == input->spec.init) {
      properties.add(input->name,
                     described("expression", with_unit(input->spec.doc, input->spec.unit, shortest(input->spec.init))));
    }
  }
  std::vector<std::string> needed{"type"};
  for (const Number* n : block.numbers) {
    const bool has_default = n->spec.init == n->spec.init;
    if (!has_default && !n->spec.optional) needed.emplace_back(n->name);
    properties.add(n->name, described("expression",
                                      with_unit(n->spec.doc, n->spec.unit, has_default ? shortest(n->spec.init) : "")));
  }
  for (const Table* t : block.tables) {
    if (t->spec.init.empty() && !t->spec.optional) needed.emplace_back(t->name);
    properties.add(t->name, described("expression", with_unit(t->spec.doc, t->spec.unit, std::string(t->spec.init))));
  }
  for (const Count* c : block.counts) {
    properties.add(c->name, described("expression", with_unit(c->spec.doc, {}, std::to_string(c->spec.init))));
  }
  for (const Choice* c : block.choices) {
    std::vector<std::string> words = c->words;
    properties.add(c->name, Object().add("enum", of_strings(words)).add("description", quoted(c->doc)).text());
  }
  for (const Text* t : block.texts) {
    if (!type.written.empty()) needed.emplace_back(t->name);
    if (const std::string form = form_of(type, t->name); !form.empty()) {
      properties.add(t->name, form);
      continue;
    }
    properties.add(t->name, Object().add("type", quoted("string")).add("description", quoted(t->spec.doc)).text());
  }
  for (const char* key : {"in", "rate", "reset", "enable", "trigger", "repeat", "first", "last", "doc", "unit", "label",
                          "zero_crossing", "priority"}) {
    properties.add(key, reference(std::string("key_") + key));
  }
  return Object()
      .add("description", quoted(type.summary))
      .add("type", quoted("object"))
      .add("properties", properties.text())
      .add("required", of_strings(needed))
      .add("additionalProperties", "false")
      .text();
}

// The keys of any instance and the pieces of the other sections.
void add_common(Object& definitions) {
  definitions.add("expression",
                  R"({"type":["number","string","boolean","array"],"description":"a number or an expression"})");
  definitions.add("key_in", R"({"type":["number","string","array","object"],"description":"what feeds the inputs"})");
  definitions.add(
      "key_rate",
      R"({"anyOf":[{"$ref":"#/$defs/expression"},{"type":"object","properties":{"period":{"$ref":"#/$defs/expression"},)"
      R"("offset":{"$ref":"#/$defs/expression"}},"required":["period"],"additionalProperties":false}],)"
      R"("description":"the time between hits in s"})");
  definitions.add(
      "key_reset",
      R"({"type":"object","properties":{"when":{"$ref":"#/$defs/expression"},"edge":{"enum":["rising","falling","either"]},)"
      R"("to":{"$ref":"#/$defs/expression"}},"required":["when"],"additionalProperties":false})");
  definitions.add(
      "key_enable",
      R"({"anyOf":[{"$ref":"#/$defs/expression"},{"type":"object","properties":{"when":{"$ref":"#/$defs/expression"},)"
      R"("states":{"enum":["held","reset"]},"outputs":{"enum":["held","reset"]},"initial":{"$ref":"#/$defs/expression"}},)"
      R"("required":["when"],"additionalProperties":false}],"description":"active while this is greater than 0"})");
  definitions.add(
      "key_trigger",
      R"({"type":"object","properties":{"when":{"$ref":"#/$defs/expression"},"edge":{"enum":["rising","falling","either"]},)"
      R"("initial":{"$ref":"#/$defs/expression"}},"required":["when"],"additionalProperties":false})");
  definitions.add("key_repeat", reference("expression"));
  definitions.add("key_first", reference("key_in"));
  definitions.add("key_last", reference("key_in"));
  definitions.add("key_doc", R"({"type":"string"})");
  definitions.add("key_unit", R"({"type":"string"})");
  definitions.add("key_label", R"({"type":"string"})");
  definitions.add("key_zero_crossing", R"({"enum":[true,false,"on","off"]})");
  definitions.add("key_priority", R"({"type":"integer"})");
  definitions.add(
      "parameters",
      R"({"type":"object","additionalProperties":{"anyOf":[{"$ref":"#/$defs/expression"},{"type":"object","properties":)"
      R"({"value":{"$ref":"#/$defs/expression"},"text":{"type":"string"},"unit":{"type":"string"},"doc":{"type":"string"}},)"
      R"("additionalProperties":false}]}})");
  definitions.add("blocks", R"({"type":"object","additionalProperties":{"$ref":"#/$defs/block"}})");
  definitions.add(
      "subsystem",
      R"({"type":"object","properties":{"doc":{"type":"string"},"parameters":{"$ref":"#/$defs/parameters"},)"
      R"("inputs":{"type":["array","object"]},"outputs":{"type":["array","object"]},"blocks":{"$ref":"#/$defs/blocks"}},)"
      R"("additionalProperties":false})");
}

std::string block_definition() {
  std::string cases;
  for (const BlockType& type : catalogue()) {
    const std::string is_type =
        Object()
            .add("properties", Object().add("type", Object().add("const", quoted(type.name)).text()).text())
            .add("required", R"(["type"])")
            .text();
    cases += (cases.empty() ? "" : ",") +
             Object().add("if", is_type).add("then", reference("block_" + std::string(type.name))).text();
  }
  const std::string mapping = Object()
                                  .add("type", quoted("object"))
                                  .add("anyOf", R"([{"required":["type"]},{"required":["expr"]}])")
                                  .add("allOf", "[" + cases + "]")
                                  .text();
  return Object().add("anyOf", "[" + reference("expression") + "," + mapping + "]").text();
}

// ---- figures

// "a panel" -> "figure_panel"
std::string definition_name(const FigureWords& words) {
  const std::size_t blank = words.what.find(' ');
  return "figure_" + std::string(words.what.substr(blank == std::string_view::npos ? 0 : blank + 1));
}

std::string any_of(std::initializer_list<std::string> schemas) {
  return fmt::format("\"anyOf\":[{}]", fmt::join(schemas.begin(), schemas.end(), ","));
}

std::string list_of(const std::string& items) {
  return Object().add("type", quoted("array")).add("items", items).text();
}

std::string schema_of(const FigureWord& word) {
  using Kind = FigureWord::Kind;
  const std::string number = reference("expression"), text = R"({"type":"string"})";
  const std::string parts = word.parts ? reference(definition_name(*word.parts)) : "";
  std::string says;
  switch (word.kind) {
    case Kind::text:
      says = R"("type":"string")";
      break;
    case Kind::texts:
      says = any_of({text, list_of(text)});
      break;
    case Kind::number:
    case Kind::signal:
      says = "\"$ref\":\"#/$defs/expression\"";
      break;
    case Kind::numbers:
    case Kind::limits:
      says = R"("type":"array")";
      break;
    case Kind::flag:
      says = R"("type":"boolean")";
      break;
    case Kind::choice:
      says = "\"enum\":" + of_strings({word.choices.begin(), word.choices.end()});
      break;
    case Kind::color:
      says = any_of({"{\"enum\":" + of_strings({word.choices.begin(), word.choices.end()}) + "}",
                     R"({"type":"string","pattern":"^#[0-9a-fA-F]{3,8}$"})"});
      break;
    case Kind::signals:
      says = any_of({number, parts, list_of("{" + any_of({number, parts}) + "}")});
      break;
    case Kind::column:
    case Kind::grid:
      says = any_of({number, R"({"type":"array"})"});
      break;
    case Kind::axis:
      says = any_of({text, parts});
      break;
    case Kind::list:
      says = "\"type\":\"array\",\"items\":" + parts;
      break;
    case Kind::plot:
      says = any_of({parts, list_of(parts)});
      break;
  }
  return "{" + says + ",\"description\":" + quoted(word.doc) + "}";
}

void add_figures(Object& definitions, const PlotWords& plots) {
  const auto add = [&](const FigureWords& words, bool with_plots) {
    Object properties;
    for (const FigureWord& word : words.words) properties.add(word.name, schema_of(word));
    if (with_plots)
      for (const FigureWord& plot : plots) properties.add(plot.name, schema_of(plot));
    definitions.add(definition_name(words), Object()
                                                .add("type", quoted("object"))
                                                .add("properties", properties.text())
                                                .add("additionalProperties", "false")
                                                .text());
  };
  for (const FigureWords* words :
       {&figure_words(), &axis_words(), &curve_words(), &line_words(), &band_words(), &remark_words()})
    add(*words, false);
  add(panel_words(), true);
  add(inset_words(), true);
  for (const FigureWord& plot : plots) add(*plot.parts, false);
}

}  // namespace

std::string diagram_schema(const PlotWords& plots) {
  Object definitions;
  add_common(definitions);
  for (const BlockType& type : catalogue()) definitions.add("block_" + std::string(type.name), definition_of(type));
  definitions.add("block", block_definition());
  add_figures(definitions, plots);

  Object simulation;
  for (const char* key : {"stop", "start", "step", "rtol", "atol", "max_step", "output_interval", "event_tol",
                          "max_steps", "max_rows", "seed"}) {
    simulation.add(key, reference("expression"));
  }
  simulation.add("solver", R"({"type":"string"})");
  simulation.add("zeno", R"({"enum":["error","hold","ignore"]})");
  simulation.add("loops", R"({"enum":["error","solve"]})");
  simulation.add("strict", R"({"type":"boolean"})");

  Object properties;
  properties.add("plantloop", R"({"const":1})");
  properties.add("title", R"({"type":"string"})");
  properties.add("import", R"({"type":["array","object"]})");
  properties.add("parameters", reference("parameters"));
  properties.add("blocks", reference("blocks"));
  properties.add("types", R"({"type":"object","additionalProperties":{"$ref":"#/$defs/subsystem"}})");
  properties.add("simulation", Object()
                                   .add("type", quoted("object"))
                                   .add("properties", simulation.text())
                                   .add("additionalProperties", "false")
                                   .text());
  properties.add("record", R"({"type":["array","object"]})");
  properties.add("figures", Object()
                                .add("type", quoted("object"))
                                .add("additionalProperties", reference(definition_name(figure_words())))
                                .text());
  properties.add("expect", R"({"type":"array","items":{"type":"object"}})");
  properties.add("checks", R"({"type":"object"})");

  return Object()
             .add("$schema", quoted("https://json-schema.org/draft/2020-12/schema"))
             .add("title", quoted("Plantloop diagram, format 1"))
             .add("type", quoted("object"))
             .add("properties", properties.text())
             .add("required", R"(["plantloop"])")
             .add("additionalProperties", "false")
             .add("$defs", definitions.text())
             .text() +
         "\n";
}

}  // namespace plantloop
