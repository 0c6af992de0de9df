#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <vector>

#include <Friction_cst.h>
#include <SiconosKernel.hpp>
#include <SolverOptions.h>

#include "disks_rival.h"
#include "ratio.h"

namespace
{

using disk = std::shared_ptr<LagrangianLinearTIDS>;

disk make_disk(const disks &d, int i)
{
  auto q = std::make_shared<SiconosVector>(3), v = std::make_shared<SiconosVector>(3);
  auto M = std::make_shared<SimpleMatrix>(3, 3);
  M->zero();
  q->zero();
  v->zero();
  (*q)(0) = 3 * d.radius * i;
  (*q)(1) = d.radius;
  (*M)(0, 0) = (*M)(1, 1) = d.mass;
  (*M)(2, 2) = d.mass * d.radius * d.radius / 2;
  auto made = std::make_shared<LagrangianLinearTIDS>(q, v, M);
  auto weight = std::make_shared<SiconosVector>(3);
  weight->zero();
  (*weight)(1) = -d.mass * d.gravity;
  made->setFExtPtr(weight);
  return made;
}

/* The normal and the tangent of the lowest point. */
std::shared_ptr<Interaction> make_contact(const disks &d)
{
  auto H = std::make_shared<SimpleMatrix>(2, 3);
  auto b = std::make_shared<SiconosVector>(2);
  H->zero();
  b->zero();
  (*H)(0, 1) = 1;
  (*H)(1, 0) = 1;
  (*H)(1, 2) = d.radius;
  (*b)(0) = -d.radius;
  return std::make_shared<Interaction>(std::make_shared<NewtonImpactFrictionNSL>(0.0, 0.0, d.mu, 2),
                                       std::make_shared<LagrangianLinearTIR>(H, b));
}

int failures; // problems that its solver gave up

void check(int info, Simulation *)
{
  failures += info != 0;
}

double run(const disks &d, double *fastest)
{
  auto system = std::make_shared<NonSmoothDynamicalSystem>(0, d.steps * d.dt);
  std::vector<disk> all;
  for (int i = 0; i < d.count; i++) {
    all.push_back(make_disk(d, i));
    system->insertDynamicalSystem(all.back());
    system->link(make_contact(d), all.back());
  }
  auto scheme = std::make_shared<MoreauJeanOSI>(0.5);
  auto grid = std::make_shared<TimeDiscretisation>(0, d.dt);
  auto contacts = std::make_shared<FrictionContact>(2, SICONOS_FRICTION_2D_NSGS);
  contacts->setMStorageType(NM_SPARSE_BLOCK);
  auto simulation = std::make_shared<TimeStepping>(system, grid, scheme, contacts);
  simulation->setCheckSolverFunction(check);
  simulation->setNewtonOptions(SICONOS_TS_LINEAR); // one iteration: all is linear
  failures = 0;
  simulation->initialize();
  double start = ratio_cpu();
  for (int i = 0; i < d.steps; i++) {
    simulation->computeOneStep();
    simulation->nextStep();
  }
  double taken = ratio_cpu() - start;
  if (failures > 0) return std::numeric_limits<double>::infinity();
  *fastest = 0;
  for (const auto &one : all)
    for (unsigned j = 0; j < 3; j++) *fastest = std::max(*fastest, std::abs((*one->velocity())(j)));
  return taken;
}

} // namespace

double siconos_disks(const disks *d, double *fastest)
{
  try {
    return run(*d, fastest);
  } catch (const std::exception &) {
    return -1;
  }
}
