#include <algorithm>
#include <exception>
#include <limits>
#include <vector>

#include <SiconosKernel.hpp>
#include <SolverOptions.h>
#include <lcp_cst.h>

#include "steps_rival.h"
#include "ratio.h"

namespace
{

using ball = std::shared_ptr<LagrangianLinearTIDS>;

ball make_ball(const column &c, int i)
{
  auto q = std::make_shared<SiconosVector>(1), v = std::make_shared<SiconosVector>(1);
  auto M = std::make_shared<SimpleMatrix>(1, 1);
  (*q)(0) = column_height(&c, i);
  (*M)(0, 0) = c.mass;
  auto made = std::make_shared<LagrangianLinearTIDS>(q, v, M);
  auto weight = std::make_shared<SiconosVector>(1);
  (*weight)(0) = -c.mass * c.gravity;
  made->setFExtPtr(weight);
  return made;
}

/* g = q_i - q_(i-1) - 2 r, for the first ball q_0 - r. */
std::shared_ptr<Interaction> make_contact(const column &c, int i)
{
  auto H = std::make_shared<SimpleMatrix>(1, i > 0 ? 2 : 1);
  auto b = std::make_shared<SiconosVector>(1);
  if (i > 0) (*H)(0, 0) = -1;
  (*H)(0, i > 0 ? 1 : 0) = 1;
  (*b)(0) = i > 0 ? -2 * c.radius : -c.radius;
  return std::make_shared<Interaction>(std::make_shared<NewtonImpactNSL>(c.e),
                                       std::make_shared<LagrangianLinearTIR>(H, b));
}

int failures; // LCPs that its solver gave up

void check(int info, Simulation *)
{
  failures += info != 0;
}

/* Time of all steps, infinite where a problem was not solved. */
double run(const column &c, int solver, double *top)
{
  auto system = std::make_shared<NonSmoothDynamicalSystem>(0, c.steps * c.dt);
  std::vector<ball> balls;
  for (int i = 0; i < c.balls; i++) {
    balls.push_back(make_ball(c, i));
    system->insertDynamicalSystem(balls.back());
  }
  for (int i = 0; i < c.balls; i++) {
    auto at = static_cast<std::size_t>(i);
    if (i == 0)
      system->link(make_contact(c, 0), balls[0]);
    else
      system->link(make_contact(c, i), balls[at - 1], balls[at]);
  }
  auto scheme = std::make_shared<MoreauJeanOSI>(0.5);
  auto grid = std::make_shared<TimeDiscretisation>(0, c.dt);
  auto contacts = std::make_shared<LCP>(solver);
  if (solver == SICONOS_LCP_NSGS_SBM) contacts->setMStorageType(NM_SPARSE_BLOCK);
  auto simulation = std::make_shared<TimeStepping>(system, grid, scheme, contacts);
  simulation->setCheckSolverFunction(check);
  failures = 0;
  simulation->initialize();
  double start = ratio_cpu();
  for (int i = 0; i < c.steps; i++) {
    simulation->computeOneStep();
    simulation->nextStep();
  }
  double taken = ratio_cpu() - start;
  if (failures > 0) return std::numeric_limits<double>::infinity();
  *top = (*balls.back()->q())(0);
  return taken;
}

} // namespace

double siconos_column(const column *c, double *top)
{
  try {
    double lemke = run(*c, SICONOS_LCP_LEMKE, top),
           gauss_seidel = run(*c, SICONOS_LCP_NSGS_SBM, top);
    return std::min(lemke, gauss_seidel);
  } catch (const std::exception &) {
    return -1;
  }
}
