// What flesh is: [layers.NAME], [flesh], [contact].
#include "host/scene/material.h"
#include "host/scene/scene_keys.h"
#include "host/scene/scene_rows.h"

namespace fascicle::scene {
namespace {

const auto& layer_rows() {
  using namespace rows;
  static const std::tuple all{
      member("name", &Layer::name),
      key(&Layer::alpha,
          {.name = "alpha", .doc = "Stiffness of equation (4), per substep.", .range = between(0.0, 1.0)}),
      key(&Layer::alpha_outer,
          {.name = "alpha_outer",
           .doc = "Stiffness at the layer's outer side; alpha is then that of its inner side.",
           .range = between(0.0, 1.0)}),
      key(&Layer::alpha_attribute,
          {.name = "alpha_attribute",
           .doc =
               "Painted values that the stiffness is multiplied by, alpha (0 to 1) or the modulus (0.01 to "
               "10): _STIFFNESS, COLOR_0.g; empty: none."}),
      key(&Layer::youngs_modulus, {.name = "youngs_modulus",
                                   .doc = "Stiffness with the implicit integrator: Young's modulus, Pa.",
                                   .range = positive(1e12)}),
      key(&Layer::frequency,
          {.name = "frequency",
           .doc = "Stiffness with the implicit integrator: the layer's lowest mode with everything else held "
                  "still, Hz.",
           .range = positive(1e4)}),
      key(&Layer::material,
          {.name = "material",
           .doc = "Stiffness with the implicit integrator, and where absent density, of a tissue.",
           .allowed = material_names()},
          {.depends = true}),
      key(&Layer::beta,
          {.name = "beta", .doc = "Weight of the fibre, equation (14).", .range = between(0.0, 1.0)}),
      key(&Layer::damping, {.name = "damping",
                            .doc = "Rate at which the motion relative to the skeleton dies out, 1/s.",
                            .range = between(0.0, 1e4)}),
      key(&Layer::damping_ratio,
          {.name = "damping_ratio",
           .doc = "In place of damping, with the implicit integrator: of the layer's lowest mode; 1 is "
                  "critical.",
           .range = between(0.0, 100.0)}),
      key(&Layer::density, {.name = "density", .doc = "Density, kg/m^3.", .range = between(1e-3, 1e5)}),
      key(&Layer::fibre,
          {.name = "fibre",
           .doc = "Direction of the fibres at rest; its length and sign mean nothing.",
           .range = coordinate},
          {.by_hand = true}),
      key(&Layer::fibre_field,
          {.name = "fibre_field",
           .doc = "The fibres follow the bones inside and the skin outside: equations (1) to (3)."}),
      key(&Layer::kinematic,
          {.name = "kinematic",
           .doc = "Moved by the skeleton alone, or held still where there is none: bone."}),
      key(&Layer::sliding,
          {.name = "sliding",
           .doc = "Skin: slides along the flesh of layers that do not slide and keeps its distance from it; "
                  "attached where it meets bone."},
          {.shown = Shown::where_set}),
      key(&Layer::inertia_scale,
          {.name = "inertia_scale",
           .doc = "Share of the skeleton's acceleration that the flesh feels; 0: it is carried along; above "
                  "1: it feels more than there is.",
           .range = between(0.0, most_inertia)}),
      key(&Layer::volume,
          {.name = "volume",
           .doc = "How strongly volume is drawn back to rest; 1: as strongly as the stiffness leaves stable.",
           .range = between(0.0, 1.0)},
          {.shown = Shown::where_set}),
      key(&Layer::least_volume,
          {.name = "least_volume",
           .doc = "Share of its volume at rest below which no tetrahedron is crushed, with the implicit "
                  "integrator; 0: none. Where absent, 0.3 for a character, else 0.",
           .range = between(0.0, 0.9)},
          {.depends = true, .shown = Shown::where_set}),
      key(&Layer::contact,
          {.name = "contact", .doc = "Where flesh meets: its flesh does. false: it meets nothing."},
          {.shown = Shown::where_set}),
      where_key(&Layer::where, false,
                "What belongs to the layer; where absent, all that no other layer claims."),
      member("by_paint", &Layer::by_paint, Shown::never)};
  static_assert(base::has_row_for_each_member<Layer, decltype(all)>, "a member of Layer has no row here");
  return all;
}

const auto& flesh_rows() {
  using namespace rows;
  static const std::tuple all{
      key(&FleshSettings::softness,
          {.name = "softness",
           .doc = "How many times as soft: the stiffness of all layers that move by themselves is divided by "
                  "it.",
           .range = between(0.01, 100.0)}),
      key(&FleshSettings::exaggerate,
          {.name = "exaggerate",
           .doc =
               "How many times as much of the skeleton's acceleration all flesh feels, so that it trails and "
               "jiggles as many times as far.",
           .range = between(0.0, most_inertia)})};
  static_assert(base::has_row_for_each_member<FleshSettings, decltype(all)>,
                "a member of FleshSettings has no row here");
  return all;
}

const auto& contact_rows() {
  using namespace rows;
  static const std::tuple all{
      key(&ContactSettings::self,
          {.name = "self",
           .doc =
               "Flesh of the body does not pass through other flesh of it; of several characters each one's "
               "own. Flesh of one and that of another, or a prop, meet whatever this says."}),
      key(&ContactSettings::distance,
          {.name = "distance",
           .doc =
               "Flesh that lies nearer than that at rest does not meet, m. Where absent, twice the mean "
               "edge of the tetrahedra's surface. At most a tenth of the body's diagonal, or four of these "
               "edges if that is more.",
           .range = positive(1e3)}),
      key(&ContactSettings::friction, {.name = "friction",
                                       .doc = "Coulomb's coefficient of friction between flesh and flesh.",
                                       .range = between(0.0, 100.0)}),
      key(&ContactSettings::ignore,
          {.name = "ignore",
           .doc =
               "Flesh that does not meet: [[\"thigh_L\", \"belly\"], [\"tail\"]]. Two names do not meet each "
               "other, one alone meets nothing. A name is a joint's, and stands for its flesh and that of "
               "all joints below it, or a layer's, an object's or a material's."}),
      key(&ContactSettings::attribute,
          {.name = "attribute",
           .doc = "Painted values: flesh where they are below 0.5 meets nothing: _CONTACT, COLOR_0.b; empty: "
                  "none."})};
  static_assert(base::has_row_for_each_member<ContactSettings, decltype(all)>,
                "a member of ContactSettings has no row here");
  return all;
}

}  // namespace

const Table& layer_table() {
  static const Table table =
      with_keys({.name = "layer",
                 .doc = "A layer of the body. Where several claim a point, the last of the file has it.",
                 .alternatives = {{"alpha", "youngs_modulus", "frequency", "material"},
                                  {"alpha_outer", "youngs_modulus", "frequency", "material"},
                                  {"damping", "damping_ratio"}}},
                layer_rows());
  return table;
}
void read_keys(const toml::table& table, Layer& layer) {
  read_rows(table, layer_rows(), layer);
}
Json json_of(const Layer& layer) {
  return json_of_rows(layer_rows(), layer);
}

const Table& flesh_table() {
  static const Table table =
      with_keys({.name = "flesh", .doc = "What is wished of all flesh at once."}, flesh_rows());
  return table;
}
void read_keys(const toml::table& table, FleshSettings& flesh) {
  read_rows(table, flesh_rows(), flesh);
}
Json json_of(const FleshSettings& flesh) {
  return json_of_rows(flesh_rows(), flesh);
}

const Table& contact_table() {
  static const Table table = with_keys({.name = "contact", .doc = "How flesh meets flesh."}, contact_rows());
  return table;
}
void read_keys(const toml::table& table, ContactSettings& contact) {
  read_rows(table, contact_rows(), contact);
}
Json json_of(const ContactSettings& contact) {
  return json_of_rows(contact_rows(), contact);
}

}  // namespace fascicle::scene
