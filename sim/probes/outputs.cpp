#include "sim/probes/outputs.h"

#include <algorithm>
#include <cmath>

#include "sim/case/case_error.h"
#include "sim/case/case_schema.h"
#include "sim/case/case_table_reader.h"
#include "sim/case/case_text.h"
#include "sim/case/case_tree.h"
#include "sim/case/located_text.h"
#include "sim/probes/probe.h"
#include "sim/trajectory/json_text.h"

namespace weft::sim {

namespace {

std::string without_spaces(const std::string& text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

}  // namespace

void check_outputs(const std::vector<OutputExpression>& outputs,
                   const TrajectoryContents& contents) {
  for (const OutputExpression& output : outputs) const Probe probe(output.text, contents);
}

OutputValues evaluate_outputs(const std::vector<OutputExpression>& outputs,
                              const TrajectoryReader& reader) {
  RecordedValues recorded(reader);
  OutputValues values;
  for (const OutputExpression& output : outputs)
    values.emplace_back(output.name, Probe(output.text, recorded.contents()).value(recorded));
  return values;
}

std::vector<OutputExpression> recorded_outputs(const TrajectoryReader& reader,
                                               const std::string& path) {
  const std::string text = reader.case_text(), place = path + ":case";
  const toml::table tree = parse_toml(text, place);
  const toml::node* outputs = tree.get("outputs");
  if (outputs == nullptr) return {};
  Case prototype;
  Locations locations(place);
  read_field(*describe(prototype).find("outputs"), *outputs, "outputs", locations);
  for (OutputExpression& output : prototype.outputs)
    output.text = located_text(output.text.text, output.text.location, text);
  return std::move(prototype.outputs);
}

OutputExpression output_of(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) {
    throw CaseError({text}, "no \"=\"",
                    "expected NAME = EXPRESSION, such as stretch = max(largest_stretch)");
  }
  const std::string name = without_spaces(text.substr(0, equals));
  if (!is_identifier(name)) {
    throw CaseError({text}, in_quotes(name) + " is not a name",
                    "expected a name of letters, digits, _ and -");
  }
  return {name, {without_spaces(text.substr(equals + 1)), {"output " + name}}};
}

std::vector<OutputExpression> outputs_of(const std::vector<std::string>& texts) {
  std::vector<OutputExpression> outputs;
  for (const std::string& text : texts) {
    OutputExpression output = output_of(text);
    if (std::ranges::find(outputs, output.name, &OutputExpression::name) != outputs.end()) {
      throw CaseError({text}, in_quotes(output.name) + " is given twice",
                      "expected a name of its own for each output");
    }
    outputs.push_back(std::move(output));
  }
  return outputs;
}

std::string to_text(const OutputValues& outputs) {
  std::size_t width = 0;
  for (const auto& [name, value] : outputs) width = std::max(width, name.size());
  std::string text;
  for (const auto& [name, value] : outputs) {
    text += name + std::string(width - name.size() + 2, ' ') +
            (std::isnan(value) ? "no number" : number_text(value)) + '\n';
  }
  return text;
}

std::string to_json(const OutputValues& outputs) {
  nlohmann::ordered_json object = nlohmann::ordered_json::object();
  for (const auto& [name, value] : outputs) object[name] = value;  // NaN becomes null
  return json_text(object);
}

}  // namespace weft::sim
