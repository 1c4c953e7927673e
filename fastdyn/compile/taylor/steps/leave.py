"""The end of a kernel: the record and the rows are stored."""

from fastdyn.kernels.state.record import FINISHED, RAISED, STEP_TOO_SMALL, Y_OLD, K, Y
from fastdyn.kernels.state.series import HIGHEST, LOW, SCALE

from ..text.frame import AT, add


def leave(driver):
    """Emit the stores of the record and the rows."""
    text, n = driver.text, driver.n
    text.label("over")
    text.put(f"ret i64 {FINISHED}")
    if driver.plan.raises():
        text.label("raises")  # by rounded differences: ask the function itself
        text.put(f"br i1 {driver.asked(text.load(driver.var['t']))}, label %lost, label %defined")
    text.label("lost")
    y, raised = driver.room["y"], driver.asked(text.load(driver.var["t"]))
    text.put(f"%lost_status = select i1 {raised}, i64 {RAISED}, i64 {STEP_TOO_SMALL}")
    for i in range(n):
        text.store(text.load(text.at(y, i)), text.at("%work", Y_OLD * n + i))
    text.put("br label %leave")
    _copy(driver)
    _write(driver)


def _copy(driver):
    """Copy the coefficients to the rows."""
    text, n = driver.text, driver.n
    text.label("done")
    text.put(f"%taken_status = load i64, ptr {driver.status}")
    for i in range(n):
        text.store(text.load(text.at(driver.rows, i)), text.at("%work", Y_OLD * n + i))
    rest = text.at("%work", (K + driver.order + 1) * n)
    text.clear(rest, n * (HIGHEST - driver.order))
    text.put("br label %copy")
    text.label("copy")
    text.put("%copied = phi i64 [0, %done], [%copied_next, %copy]")
    source = text.at(driver.rows, text.new(f"mul i64 %copied, {driver.row}"))
    target = text.at("%work", text.new(f"add i64 {text.new(f'mul i64 %copied, {n}')}, {K * n}"))
    for i in range(n):
        text.store(text.load(text.at(source, i)), text.at(target, i))
    text.put("%copied_next = add i64 %copied, 1")
    text.put(f"%copied_more = icmp sle i64 %copied_next, {driver.order}")
    text.put("br i1 %copied_more, label %copy, label %leave")


def _write(driver):
    """Write the state to the rows and the record."""
    text, n = driver.text, driver.n
    text.label("leave")
    text.put("%result = phi i64 [%lost_status, %lost], [%taken_status, %copy]")
    for name, row in (("y", Y), ("low", LOW)):
        for i in range(n):
            text.store(text.load(text.at(driver.room[name], i)), text.at("%work", row * n + i))
    text.store(text.load(driver.var["scale"]), text.at("%work", SCALE * n))
    for name in ("t", "t_old", "h"):
        text.store(text.load(driver.var[name]), text.at("%state", AT[name]))
    counts = {"n_accepted": driver.taken, "n_rejected": driver.refused, "n_equal": driver.at_rest}
    for name, place in counts.items():
        add(text, name, place)
    text.put("ret i64 %result")
