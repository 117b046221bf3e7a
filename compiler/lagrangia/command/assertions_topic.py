"""The text of `lag help assertions`."""

ASSERTIONS = """\
    equation
      assert(m < 5[kg], "too heavy for the crane");
      assert(norm(hinge.reaction) < 2[kN], "the bearing breaks", AssertionLevel.warning);
      when door.phi < 0 then terminate("the door is shut"); end when;

assert(condition, text)    has to hold in the whole run. Where it breaks, exactly, the run fails (exit code 1) with the text, the
                           time, the place, and the values of what the condition names; the rows before it are kept.
AssertionLevel.warning     as a third argument: the run goes on, and says when the condition broke at first (L0610).
terminate(text)            in a `when`: the run ends where the condition comes true, well (exit code 0), and says the text. The
                           last row is the one there. A condition that is true at the start has to be false before it comes true.

In a function, assert holds for every call, where the call is reckoned: f(x) in a branch that is not taken is not asked. The
place that is told is that of the call. Texts are put together: "n = " + String(n); what an assertion says may name what a run
alone knows, String(x), and has its value beside it.

Conditions compare with <, <=, >, >= what moves, accelerations and forces in joints too, parameters and time; and, or, not join
them. What has no value (NaN) does not hold. Structural ones (Integer, Boolean, constants) are checked by `lag check`, those of
parameters where a run starts (error L0605, exit code 2) and where one of them is set.

They are looked at after each step, in its dense output, so that the motion is the same with them or without, in every solver
but islands and CasADi's, which refuse them (runs of sweeps that go on eight at a time may take a method with dense output
then, and up to twice the steps: the same motion within the tolerance). A condition counts as broken that is so by more than
an error of one tolerance in the state would make of it: what rests at a contact does not break x >= 0. Sweeps: a run whose
assertion breaks is a failed row with its text, warnings are counted, and measures of a run that is terminated go up to its
end, `final` too. FMUs: Co-Simulation ends at the same times, with an error, or by asking the importer to terminate; in Model
Exchange completed steps are looked at. In Python: RunError; run.ended, run.warnings; runs in steps and prepared ones have
`ended` too. `lag test` runs models whose names begin with Test, and fails where their assertions do. Positions of rest, modes
and linearizations do not ask for them.
"""
