// The weights w_ir of the Oracle, from the rest data alone: equations (12), (13), (14) and momentum scaling.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include "host/model/model.h"

namespace fascicle::cpu_reference {

// The matrix of w_ir, row i (vertex), column r (region), stored twice: one is read along a vertex's regions,
// the other along a region's vertices. Both have an entry for every i in N_r, even if it is zero.
struct Weights {
  Eigen::SparseMatrix<double, Eigen::RowMajor> of_vertex;
  Eigen::SparseMatrix<double, Eigen::ColMajor> of_region;
};

// w_ir in kg, momentum-scaled if the model says so (then the sum over r of w_ir is s_i).
Weights region_weights(const model::Model& model);

// r_i, equation (13): vertex i relative to the centre of mass of region r, at rest.
Eigen::Vector3d offset_from_mass_centre(const model::Model& model, std::uint32_t i, std::uint32_t r);

// w_ir / m_i as printed, equations (12) and (14), for fibre d (unit, or zero: no fibre), weight beta and
// offset r_i.
double fibre_weight(const Eigen::Vector3d& d, double beta, const Eigen::Vector3d& r_i,
                    model::WeightForm form);

}  // namespace fascicle::cpu_reference
