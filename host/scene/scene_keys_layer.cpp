// The flesh: [layers.NAME], [flesh], [contact].
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
           .doc = "Stiffness at the layer's outer side; alpha then applies at its inner side.",
           .range = between(0.0, 1.0)}),
      key(&Layer::alpha_attribute,
          {.name = "alpha_attribute",
           .doc = "Painted attribute that the stiffness is multiplied by, alpha (0 to 1) or the modulus "
                  "(0.01 to 10): _STIFFNESS, COLOR_0.g; empty: none."}),
      key(&Layer::youngs_modulus, {.name = "youngs_modulus",
                                   .doc = "Stiffness with the implicit integrator, as Young's modulus, Pa.",
                                   .range = positive(1e12)}),
      key(&Layer::frequency, {.name = "frequency",
                              .doc = "Stiffness with the implicit integrator, as the frequency of the "
                                     "layer's lowest mode with everything else held fixed, Hz.",
                              .range = positive(1e4)}),
      key(&Layer::material,
          {.name = "material",
           .doc = "Tissue that sets the stiffness with the implicit integrator and, if density is absent, "
                  "the density.",
           .allowed = material_names()},
          {.depends = true}),
      key(&Layer::beta,
          {.name = "beta", .doc = "Weight of the fibres, equation (14).", .range = between(0.0, 1.0)}),
      key(&Layer::damping, {.name = "damping",
                            .doc = "Decay rate of the motion relative to the skeleton, 1/s.",
                            .range = between(0.0, 1e4)}),
      key(&Layer::damping_ratio, {.name = "damping_ratio",
                                  .doc = "Damping ratio of the layer's lowest mode, with the implicit "
                                         "integrator, in place of damping; 1 is critical.",
                                  .range = between(0.0, 100.0)}),
      key(&Layer::density, {.name = "density", .doc = "Density, kg/m^3.", .range = between(1e-3, 1e5)}),
      key(&Layer::fibre,
          {.name = "fibre",
           .doc = "Direction of the fibres at rest; its length and sign are ignored.",
           .range = coordinate},
          {.by_hand = true}),
      key(&Layer::fibre_field,
          {.name = "fibre_field",
           .doc = "Fibres follow the bones inside and the skin outside, equations (1) to (3)."}),
      key(&Layer::kinematic,
          {.name = "kinematic", .doc = "Bone: moved by the skeleton alone, or held fixed if there is none."}),
      key(&Layer::sliding,
          {.name = "sliding",
           .doc = "Skin that slides along the flesh of layers that do not slide, at a constant distance; "
                  "attached where it meets bone."},
          {.shown = Shown::where_set}),
      key(&Layer::inertia_scale, {.name = "inertia_scale",
                                  .doc = "Factor on the skeleton's acceleration that the flesh feels. 0: the "
                                         "flesh is carried along; above 1: exaggerated.",
                                  .range = between(0.0, most_inertia)}),
      key(&Layer::volume,
          {.name = "volume",
           .doc = "Strength of volume preservation; 1 is the most that is stable at the layer's stiffness.",
           .range = between(0.0, 1.0)},
          {.shown = Shown::where_set}),
      key(&Layer::least_volume,
          {.name = "least_volume",
           .doc = "Share of its rest volume below which no tetrahedron is compressed, with the implicit "
                  "integrator; 0: no limit. Default: 0.3 for a character, else 0.",
           .range = between(0.0, 0.9)},
          {.depends = true, .shown = Shown::where_set}),
      key(&Layer::contact,
          {.name = "contact", .doc = "Whether the layer takes part in contact between flesh and flesh."},
          {.shown = Shown::where_set}),
      where_key(&Layer::where, false, "Region of the layer. Default: all that belongs to no other layer."),
      member("by_paint", &Layer::by_paint, Shown::never)};
  static_assert(base::has_row_for_each_member<Layer, decltype(all)>, "a member of Layer has no row here");
  return all;
}

const auto& flesh_rows() {
  using namespace rows;
  static const std::tuple all{
      key(&FleshSettings::softness,
          {.name = "softness",
           .doc = "Divides the stiffness of all layers that are not kinematic: 2 is twice as soft.",
           .range = between(0.01, 100.0)}),
      key(&FleshSettings::exaggerate, {.name = "exaggerate",
                                       .doc = "Multiplies the inertia_scale of all layers that are not "
                                              "kinematic: at 2, flesh trails and jiggles twice as far.",
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
           .doc = "Self-contact: the flesh of a body, or of each character, does not pass through itself. "
                  "Contact between characters and with props does not depend on this."}),
      key(&ContactSettings::unless_torn,
          {.name = "unless_torn",
           .doc = "Whether a bake may leave self-contact out: it does if the clip moves a limb so deep into "
                  "other flesh that contact would tear the skin. `fascicle bake` tries it first, and reports "
                  "it."}),
      key(&ContactSettings::distance,
          {.name = "distance",
           .doc = "Margin, m: flesh closer than this at rest, and not far apart along the body, is not in "
                  "contact. Default: twice the mean edge length of the tetrahedra's surface. At most a tenth "
                  "of the body's diagonal, or four of these edges if that is more.",
           .range = positive(1e3)}),
      key(&ContactSettings::friction, {.name = "friction",
                                       .doc = "Coulomb friction coefficient between flesh and flesh.",
                                       .range = between(0.0, 100.0)}),
      key(&ContactSettings::ignore,
          {.name = "ignore",
           .doc = "Flesh without contact: [[\"thigh_L\", \"belly\"], [\"tail\"]]. A pair has no contact with "
                  "each other, a single name has none at all. A name is that of a layer, an object, a "
                  "material, or a joint, which includes all joints below it. All pairs together have at most "
                  "32 names."}),
      key(&ContactSettings::attribute, {.name = "attribute",
                                        .doc = "Painted attribute; flesh has no contact where it is below "
                                               "0.5: _CONTACT, COLOR_0.b; empty: none."})};
  static_assert(base::has_row_for_each_member<ContactSettings, decltype(all)>,
                "a member of ContactSettings has no row here");
  return all;
}

}  // namespace

const Table& layer_table() {
  static const Table table = with_keys(
      {.name = "layer",
       .doc = "A layer of the body. A point in several layers belongs to the last of them in the file.",
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
      with_keys({.name = "flesh", .doc = "Adjustments to all flesh at once."}, flesh_rows());
  return table;
}
void read_keys(const toml::table& table, FleshSettings& flesh) {
  read_rows(table, flesh_rows(), flesh);
}
Json json_of(const FleshSettings& flesh) {
  return json_of_rows(flesh_rows(), flesh);
}

const Table& contact_table() {
  static const Table table =
      with_keys({.name = "contact", .doc = "Contact between flesh and flesh."}, contact_rows());
  return table;
}
void read_keys(const toml::table& table, ContactSettings& contact) {
  read_rows(table, contact_rows(), contact);
}
Json json_of(const ContactSettings& contact) {
  return json_of_rows(contact_rows(), contact);
}

}  // namespace fascicle::scene
