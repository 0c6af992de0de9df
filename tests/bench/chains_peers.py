"""A step of a spatial chain on spherical joints by nsdae, MuJoCo and Exudyn: CPU time in ms, on one core, with a step of
1 ms from rest, horizontal. A package that is not installed is left out; MuJoCo also for 1000 nested bodies, whose model
it compiles for minutes. usage: chains_peers.py"""
import os
import time

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
LENGTH, MASS, DT = 0.5, 1.0, 1e-3
INERTIA = (0.004, 0.0228, 0.0228)


def per_step(advance, steps, runs=3):
    """The least of several runs, after one that warms up."""
    advance(steps)
    least = float("inf")
    for _ in range(runs):
        start = time.process_time()
        advance(steps)
        least = min(least, time.process_time() - start)
    return 1e3 * least / steps


def of_nsdae(n, steps, method):
    import nsdae

    world, before = nsdae.Bodies(3, gravity=(0, 0, -9.81)), nsdae.GROUND
    for i in range(n):
        link = world.add(mass=MASS, inertia=INERTIA, position=(LENGTH * (i + 0.5), 0, 0))
        world.add_joint("spherical", before, link, point=(LENGTH * i, 0, 0))
        before = link
    sim = nsdae.Sim(world, method=method, dt=DT)
    sim.init()
    return per_step(lambda count: [sim.step() for _ in range(count)], steps)


def of_mujoco(n, steps):
    import mujoco

    spec = mujoco.MjSpec()
    spec.option.timestep = DT
    spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    body = spec.worldbody
    for i in range(n):
        body = body.add_body(pos=[LENGTH if i else 0, 0, 0], mass=MASS, ipos=[LENGTH / 2, 0, 0], inertia=INERTIA,
                             explicitinertial=True)
        body.add_joint(type=mujoco.mjtJoint.mjJNT_BALL)
    model = spec.compile()
    data = mujoco.MjData(model)
    return per_step(lambda count: mujoco.mj_step(model, data, nstep=count), steps)


def of_exudyn(n, steps):
    import exudyn
    import numpy
    from exudyn.utilities import RigidBodyInertia

    system = exudyn.SystemContainer().AddSystem()
    before = system.CreateGround()
    for i in range(n):
        inertia = RigidBodyInertia(mass=MASS, inertiaTensor=numpy.diag(INERTIA))
        link = system.CreateRigidBody(inertia=inertia, referencePosition=[LENGTH * (i + 0.5), 0, 0], gravity=[0, 0, -9.81])
        system.CreateSphericalJoint(itemNumbers=[before, link], position=[LENGTH * i, 0, 0], useGlobalFrame=True)
        before = link
    system.Assemble()
    settings = exudyn.SimulationSettings()
    settings.timeIntegration.verboseMode = 0
    settings.timeIntegration.newton.useModifiedNewton = True
    settings.solution.file.write = False
    settings.linearSolver.solverType = exudyn.LinearSolverType.EigenSparse

    def advance(count):
        settings.timeIntegration.numberOfSteps = count
        settings.timeIntegration.endTime = settings.timeIntegration.startTime + DT * count
        system.SolveDynamic(settings)

    once = per_step(advance, 1)  # the start of a run, which is no part of a step
    return (per_step(advance, steps + 1) * (steps + 1) - once) / steps


def main():
    peers = {"implicit": lambda *a: of_nsdae(*a, "implicit"), "moreau": lambda *a: of_nsdae(*a, "moreau"),
             "MuJoCo": of_mujoco, "Exudyn": of_exudyn}
    print(f"{'links':>6}" + "".join(f"{name:>10}" for name in peers))
    for n in (10, 100, 1000):
        row = f"{n:6d}"
        for name, step in peers.items():
            try:
                row += f"{step(n, max(5, 500 // n)):10.3f}" if name != "MuJoCo" or n <= 100 else f"{'-':>10}"
            except ImportError:
                row += f"{'-':>10}"
        print(row, flush=True)


if __name__ == "__main__":
    main()
