// The parts of reading a model, one for each section of the file.

#pragma once

#include <string>

#include "engine/diagram/document.h"
#include "engine/diagram/model.h"

namespace plantloop {

// `blocks:`; takes nodes out of the tree instead of copying them.
std::vector<BlockDecl> read_blocks(Node& node, Report& report);
// `parameters:` of the diagram, or of a type (where the keys of an instance cannot be names).
std::vector<ParameterDecl> read_parameters(const Node& node, bool of_type, Report& report);
// One entry of `types:`.
std::shared_ptr<TypeDecl> read_type(const std::string& name, const Mark& mark, Node& node, Report& report);
// Parameters, inputs and blocks of one scope have different names; an output's name is free or driven by its bearer.
void check_scope(const TypeDecl& type, Report& report);
// Types that contain themselves are reported with the chain.
void check_containment(const Model& model, Report& report);

SimulationDecl read_simulation(const Node& node, const Mark& mark, Report& report);
std::map<std::string, std::string> read_checks(const Node& node, Report& report);
std::vector<RecordDecl> read_record(const Node& node, Report& report);
std::vector<FigureDecl> read_figures(const Node& node, const PlotWords& plots, Report& report);
std::vector<ExpectDecl> read_expect(const Node& node, Report& report);

// Is this a key of any instance, which no block parameter may take?
bool is_instance_key(std::string_view key);

}  // namespace plantloop
