// Writes the scene file's JSON Schema from the table of keys.
#include <algorithm>
#include <cmath>

#include "host/scene/scene.h"
#include "host/scene/scene_table.h"

namespace fascicle::scene {
namespace {

using Json = nlohmann::ordered_json;

Json reference(const Table& table) {
  return {{"$ref", "#/$defs/" + table.name}};
}

void add_range(Json& schema, const Key& key) {
  const auto number = [&](double value) {
    const bool whole = key.type == KeyType::integer || key.type == KeyType::integer_vector;
    return whole ? Json(static_cast<std::int64_t>(value)) : Json(value);
  };
  if (std::isfinite(key.range.minimum)) {
    schema[key.range.minimum_excluded ? "exclusiveMinimum" : "minimum"] = number(key.range.minimum);
  }
  if (std::isfinite(key.range.maximum)) schema["maximum"] = number(key.range.maximum);
}

// At least one table, under user-chosen names.
Json by_name(const Table& table) {
  return {{"type", "object"},
          {"propertyNames", {{"pattern", name_pattern}, {"maxLength", longest_name}}},
          {"additionalProperties", reference(table)},
          {"minProperties", 1},
          {"maxProperties", most_named}};
}

Json schema_of(const Key& key) {
  Json schema;
  switch (key.type) {
    case KeyType::number:
    case KeyType::integer:
      schema["type"] = key.type == KeyType::number ? "number" : "integer";
      add_range(schema, key);
      // A pattern applies only to strings, as the range applies only to numbers.
      if (!key.allowed.empty()) {
        std::string words;
        for (const std::string& word : key.allowed) words += (words.empty() ? "" : "|") + word;
        schema["type"] = {schema["type"], "string"};
        schema["pattern"] = "^(" + words + ")$";
      }
      break;
    case KeyType::text:
      schema["type"] = "string";
      if (!key.allowed.empty()) schema["enum"] = key.allowed;
      break;
    case KeyType::boolean:
      schema["type"] = "boolean";
      break;
    case KeyType::vector:
    case KeyType::integer_vector: {
      Json items{{"type", key.type == KeyType::vector ? "number" : "integer"}};
      add_range(items, key);
      schema = {{"type", "array"}, {"items", items}, {"minItems", 3}, {"maxItems", 3}};
      break;
    }
    case KeyType::numbers: {
      Json items{{"type", "number"}};
      add_range(items, key);
      schema = {{"type", "array"}, {"items", items}};
      break;
    }
    case KeyType::texts:
      schema = {{"type", "array"}, {"items", {{"type", "string"}}}, {"minItems", 1}};
      break;
    case KeyType::name_lists: {
      const Json names{{"type", "array"}, {"items", {{"type", "string"}}}, {"minItems", 1}, {"maxItems", 2}};
      schema = {{"type", "array"}, {"items", names}, {"minItems", 1}};
      break;
    }
    case KeyType::points: {
      Json coordinates{{"type", "number"}};
      add_range(coordinates, key);
      schema = {{"type", "array"},
                {"items", {{"type", "array"}, {"items", coordinates}, {"minItems", 3}, {"maxItems", 3}}},
                {"minItems", 2}};
      break;
    }
    case KeyType::curve: {
      Json numbers{{"type", "number"}};
      add_range(numbers, key);
      schema = {{"type", "array"},
                {"items", {{"type", "array"}, {"items", numbers}, {"minItems", 2}, {"maxItems", 2}}},
                {"minItems", 1}};
      break;
    }
    case KeyType::named_numbers: {
      Json number{{"type", "number"}};
      add_range(number, key);
      schema = {{"type", "object"}, {"additionalProperties", number}, {"minProperties", 1}};
      break;
    }
    case KeyType::table:
      schema = reference(*key.table);
      if (key.named != nullptr) schema = {{"oneOf", {reference(*key.table), by_name(*key.named)}}};
      break;
    case KeyType::tables:
      schema["oneOf"] = {reference(*key.table),
                         {{"type", "array"}, {"items", reference(*key.table)}, {"minItems", 1}}};
      break;
    case KeyType::named_tables:
      schema = by_name(*key.table);
      if (!key.required) schema.erase("minProperties");
      break;
  }
  schema["description"] = key.doc;
  if (!key.fallback.is_null()) schema["default"] = key.fallback;
  return schema;
}

Json schema_of(const Table& table) {
  Json schema{{"type", "object"}, {"description", table.doc}};
  Json required = Json::array();
  for (const Key& key : table.keys) {
    schema["properties"][key.name] = schema_of(key);
    if (key.required) required.push_back(key.name);
  }
  schema["additionalProperties"] = false;
  if (!required.empty()) schema["required"] = required;
  for (const auto& choice : table.choices) {
    Json one_of = Json::array();
    for (const std::string& name : choice) one_of.push_back({{"required", {name}}});
    schema["allOf"].push_back({{"oneOf", one_of}});
  }
  for (const auto& group : table.alternatives)
    for (std::size_t a = 0; a < group.size(); ++a)
      for (std::size_t b = 0; b < a; ++b) {
        const Json both{{"not", {{"required", {group[b], group[a]}}}}};
        Json& all = schema["allOf"];
        if (std::find(all.begin(), all.end(), both) == all.end()) all.push_back(both);
      }
  return schema;
}

void add_definitions(Json& definitions, const Table& table) {
  for (const Key& key : table.keys)
    for (const Table* inner : {key.table, key.named}) {
      if (inner == nullptr || definitions.contains(inner->name)) continue;
      definitions[inner->name] = schema_of(*inner);
      add_definitions(definitions, *inner);
    }
}

}  // namespace

std::string scene_schema() {
  Json schema{{"$schema", "https://json-schema.org/draft/2020-12/schema"}, {"title", "fascicle scene"}};
  schema.update(schema_of(scene_table()));
  schema["$defs"] = Json::object();
  add_definitions(schema["$defs"], scene_table());
  return schema.dump(2) + "\n";
}

}  // namespace fascicle::scene
