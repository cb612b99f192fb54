"""Source texts for a bare-metal board: start-up code, linker script, and a program that measures a step."""

from __future__ import annotations

import numpy as np

from tierod.export.interface import Interface
from tierod.export.vectors import Vectors

STEPS = 1000
"""Number of measured steps."""

START = """\
#include <stdint.h>
extern uint32_t __StackTop;
extern void _start(void);
void Reset_Handler(void);
void Reset_Handler(void)
{
    *(volatile uint32_t *)0xE000ED88u |= 0xFu << 20; /* the floating-point unit */
    __asm__ volatile("dsb\\n isb");
    _start();
}
static void hang(void) { for (;;) {} }
__attribute__((section(".vectors"), used)) static const void *const vectors[] = {
    &__StackTop, (void *)Reset_Handler, (void *)hang, (void *)hang, (void *)hang, (void *)hang, (void *)hang
};
"""

LINKER_SCRIPT = """\
MEMORY { CODE (rx) : ORIGIN = 0x00000000, LENGTH = 4M  RAM (rwx) : ORIGIN = 0x20000000, LENGTH = 4M }
ENTRY(Reset_Handler)
SECTIONS {
  .text : { KEEP(*(.vectors)) *(.text*) *(.rodata*) KEEP(*(.init)) KEEP(*(.fini)) *(.ARM.extab*) } > CODE
  .ARM.exidx : { __exidx_start = .; *(.ARM.exidx*) __exidx_end = .; } > CODE
  .init_array : {
    __preinit_array_start = .; KEEP(*(.preinit_array*)) __preinit_array_end = .;
    __init_array_start = .; KEEP(*(.init_array*)) __init_array_end = .;
    __fini_array_start = .; KEEP(*(.fini_array*)) __fini_array_end = .;
  } > CODE
  .data : { *(.data*) . = ALIGN(8); } > RAM
  .bss : { __bss_start__ = .; *(.bss*) *(COMMON) . = ALIGN(8); __bss_end__ = .; end = .; __end__ = .; } > RAM
  __StackTop = ORIGIN(RAM) + LENGTH(RAM);
}
"""

_MEASURE = """\
#define SYST_CSR (*(volatile unsigned *)0xE000E010u)
#define SYST_RVR (*(volatile unsigned *)0xE000E014u)
#define SYST_CVR (*(volatile unsigned *)0xE000E018u)
#define INSTRUCTIONS_PER_TICK 40u /* 25 MHz beside one instruction in a nanosecond */
#define PAINTED 16384u

static unsigned char *below(void)
{
    unsigned char here;
    unsigned char *volatile place = &here;
    return place;
}

__attribute__((noinline)) static void paint(void)
{
    volatile unsigned char *place = below() - 64;
    for (unsigned k = 0; k < PAINTED; k++) { place[-(int)k] = 0xA5u; }
}

__attribute__((noinline)) static unsigned depth(unsigned char *top)
{
    volatile unsigned char *lowest = below() - 64 - PAINTED + 256;
    while (*lowest == 0xA5u) { lowest++; }
    return (unsigned)(top - lowest);
}

int main(void)
{
    static OUTPUT_T output;
    unsigned long total = 0, most = 0, deepest = 0;

    begin();
    SYST_RVR = 0xFFFFFFu;
    SYST_CVR = 0u;
    SYST_CSR = 5u;
    for (int k = 0; k < STEPS; k++) {
        double row[INPUTS + 1];
        SAMPLE_T sample;
        for (int i = 0; i < INPUTS; i++) { row[i] = (double)drive[k * INPUTS + i]; }
        sample = taken(row);
        paint();
        const unsigned before = SYST_CVR;
        STEP(&constants, &state, &sample, &output);
        const unsigned spent = (before - SYST_CVR) & 0xFFFFFFu;
        const unsigned used = depth(below());
        total += spent;
        most = (spent > most) ? spent : most;
        deepest = (used > deepest) ? used : deepest;
    }
    printf("mean %.1f most %lu stack %lu state %u constants %u\\n", (double)total * INSTRUCTIONS_PER_TICK / STEPS,
           most * INSTRUCTIONS_PER_TICK, deepest, (unsigned)sizeof state, (unsigned)sizeof constants);
    return 0;
}
"""


def measuring_program(face: Interface, vectors: Vectors) -> str:
    """C code that counts instructions and stack use of a step over the last test vectors.

    Args:
        vectors: test vectors; the last inputs are used
    """
    taken = vectors.inputs[-STEPS:]
    numbers = ",\n".join(", ".join(_written(value) for value in row) for row in taken.tolist())
    prefix = face.prefix
    return (
        '#define TIEROD_NO_MAIN\n#include "../test/compare.c"\n\n#include <stdio.h>\n\n'
        f"#define STEPS {len(taken)}\n#define STEP {prefix}_step\n#define SAMPLE_T {prefix}_sample_t\n"
        f"#define OUTPUT_T {prefix}_output_t\n\nstatic const float drive[STEPS * INPUTS] = {{\n{numbers}\n}};\n\n"
        f"{_MEASURE}"
    )


def _written(value: float) -> str:
    return "NAN" if np.isnan(value) else f"{value!r}f" if np.isfinite(value) else "INFINITY"
