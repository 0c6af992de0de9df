"""Step by step, the state as a value, options on the way."""

import copy
import pickle

import numpy as np
import pytest

import nsdae
from conftest import G


def started(system, **options):
    sim = nsdae.Sim(system, **options)
    sim.init([1])
    return sim


def test_steps_and_a_run_are_the_same(ball):
    whole = nsdae.solve(ball, 1.003, [1])
    sim = started(ball)
    records = [sim.record] + list(sim.steps(1.003))
    assert np.array_equal([r.time for r in records], whole.time)
    assert np.array_equal([r.q for r in records], whole.q)
    assert sum(len(r.impacts) for r in records) == len(whole.impacts)
    assert records[3].q is not records[4].q


def test_step_tells_of_an_impact(ball):
    sim = started(ball)
    statuses = [sim.step() for _ in range(100)]
    assert nsdae.Status.EVENT in statuses and nsdae.Status.OK in statuses
    hit = started(ball)
    assert hit.run_to_event(5) == nsdae.Status.EVENT
    assert hit.time == pytest.approx(np.sqrt(2 / 9.81), abs=0.0051 * 3)
    assert len(hit.record.impacts) == 1


def test_state_is_a_value(ball):
    sim = started(ball)
    sim.run(0.7)
    kept = sim.state
    sim.run(1.5)
    there = sim.record.q, sim.state
    other = started(ball)
    other.state = kept
    other.run(1.5)
    assert np.array_equal(other.record.q, there[0]) and other.state == there[1]
    with pytest.raises(nsdae.ArgumentError):
        sim.state = kept[:-1]
    with pytest.raises(nsdae.ArgumentError):
        sim.state = bytes(len(kept))


def test_options_and_coefficients_on_the_way(ball):
    sim = started(ball)
    sim.run(0.3)
    sim.set_options(dt=1e-3)
    assert sim.options["dt"] == 1e-3
    sim.set_contact(0, e_n=0)
    sim.run(2)
    assert abs(sim.record.v[0]) < 1e-12 and sim.stats["impacts"] == 1
    with pytest.raises(nsdae.ArgumentError, match="method"):
        sim.set_options(method="moreau")


def test_interpolation_meets_the_ends(ball):
    sim = started(ball)
    sim.step()
    q, v = sim.interpolate(sim.time)
    assert np.array_equal(q, sim.record.q) and np.array_equal(v, sim.record.v)
    with pytest.raises(nsdae.ArgumentError):
        sim.interpolate(7)


def test_projection_of_a_start(pendulum):
    q0, v0 = nsdae.Sim(pendulum).project([1.1, 0.1], [0.2, 1])
    assert q0 @ q0 == pytest.approx(1, abs=1e-12) and abs(q0 @ v0) < 1e-12
    assert nsdae.solve(pendulum, 0.1, [1.1, 0.1], project=True).status == "complete"


def test_every_keeps_the_last(ball):
    run = nsdae.solve(ball, 1.0, [1], every=7)
    whole = nsdae.solve(ball, 1.0, [1])
    assert np.array_equal(run.time, np.append(whole.time[::7], whole.time[-1]))
    assert np.array_equal(run.impacts, whole.impacts)


def test_not_started(ball):
    with pytest.raises(nsdae.Error) as caught:
        nsdae.Sim(ball).run(1)
    assert caught.value.status == nsdae.Status.E_STATE


def test_certificate_of_a_bounce(ball):
    """The law takes (1 - e^2) m v^2 / 2, the method nothing; a record is a value."""
    sim = started(ball, method="event", dt=0.01)
    sim.run_to_event(10)
    record = sim.record
    certificate = record.certificate
    lost = (1 - 0.5**2) * 0.1 * G  # m = 0.1, from 1 m
    assert abs(certificate["dissipated"] - lost) < 1e-8 and abs(certificate["unexplained"]) < 1e-8
    assert certificate["energy"] == record.kinetic + record.potential
    assert certificate["pull"] == 0 and certificate["pull_contact"] == -1
    kept = certificate.copy()
    sim.step()
    assert certificate == kept and sim.record.certificate["energy"] != kept["energy"]
    assert sim.stats["certificate"]["dissipated"] == sim.record.dissipated


def test_certificates_of_a_run(pendulum):
    """The loss of moreau is a figure of each record: the energy of its q and v."""
    run = nsdae.solve(pendulum, 1, [1, 0], method="moreau", dt=0.01)
    certificate = run.certificate
    energy = (run.v**2).sum(axis=1) / 2 + G * run.q[:, 1]
    assert energy[-1] < -1e-3
    assert np.allclose(certificate["unexplained"], energy - energy[0], rtol=0, atol=1e-11)
    assert np.allclose(certificate["work"], 0, rtol=0, atol=1e-11)
    assert np.array_equal(certificate["constraint_drift"], run.constraint_drift)
    assert np.array_equal(certificate["drift_constraint"], np.where(run.constraint_drift > 0, 0, -1))


FIELDS = set(nsdae.Record.__annotations__) | {"contacts"}


def test_only_what_is_read_is_made(ball, monkeypatch):
    """A record makes the fields that are read; time, q, v and contacts of a simulation make no record."""
    sim = started(ball)
    sim.run_to_event(5)
    record = sim.record
    assert FIELDS.isdisjoint(vars(record))
    assert record.gap[0] == sim.contacts["gap"][0] and record.q is record.q
    assert FIELDS & vars(record).keys() == {"contacts", "q"}
    monkeypatch.setattr(nsdae.Sim, "record", property(lambda sim: pytest.fail("a record is made")))
    while sim.time < 0.7:
        sim.step()
    assert sim.time == pytest.approx(0.7) and len(sim.q) == len(sim.v) == len(sim.contacts) == 1


def test_a_record_is_of_its_step(ball):
    """Fields that are read after further steps, and without the simulation; arrays are copies."""
    sim, twin = started(ball), started(ball)
    for one in (sim, twin):
        one.run_to_event(5)
    record, other = sim.record, twin.record
    early = {name: getattr(other, name) for name in FIELDS}
    sim.run(2)
    del sim
    for name in sorted(FIELDS):
        assert np.array_equal(getattr(record, name), early[name]), name
    assert len(record.impacts) == 1 and record.certificate["dissipated"] > 0
    before = twin.q.copy()
    twin.q[0] = twin.record.q[0] = 7
    twin.contacts["gap"] = 7
    assert np.array_equal(twin.q, before) and twin.contacts["gap"][0] != 7
    assert np.array_equal(twin.v, twin.record.v) and np.array_equal(twin.contacts, twin.record.contacts)


@pytest.mark.parametrize("again", [copy.copy, copy.deepcopy, lambda record: pickle.loads(pickle.dumps(record))])
def test_copies_of_a_record(ball, again):
    sim = started(ball)
    sim.run_to_event(5)
    record, made = sim.record, again(sim.record)
    sim.step()
    assert all(np.array_equal(getattr(made, name), getattr(record, name)) for name in FIELDS)
    with pytest.raises(AttributeError, match="'Record' object has no attribute 'qq'"):
        made.qq
    with pytest.raises(AttributeError, match="'Record' object has no attribute 'qq'"):
        record.qq
    assert FIELDS < set(dir(record))
