//! The kernels' vector instructions are instructions of the program, not calls.
//!
//! A function that is compiled for any processor cannot hold instructions that only some have. Where it uses one, the compiler makes a function of that
//! instruction and calls it, which makes a search up to three times as slow. Such functions stand in the symbol table under their names in
//! `core::core_arch`. Those that call them may have any name: a closure's caller is often one of `core`.

use std::path::Path;

use object::{Object, ObjectSymbol, SymbolKind};

/// Names of the functions in the parts of `program` that were compiled from `crate_name` and are known only there, as copies of inline functions are.
fn local_functions(program: &Path, crate_name: &str) -> Vec<String> {
    let bytes = std::fs::read(program).expect("the program can be read");
    let file = object::File::parse(&*bytes).expect("the program is an executable");
    let mut is_ours = false;
    let mut functions = Vec::new();
    // Local symbols follow the name of the object file that they come from.
    for symbol in file.symbols().filter(ObjectSymbol::is_local) {
        let name = symbol.name().unwrap_or_default();
        match symbol.kind() {
            // `crate.hash-cgu.number`, or only a hash if compiled incrementally, as none but a workspace's own crates are.
            SymbolKind::File => is_ours = name.starts_with(&format!("{crate_name}.")) || !name.contains("-cgu."),
            SymbolKind::Text if is_ours => functions.push(name.to_owned()),
            _ => {}
        }
    }
    assert!(!functions.is_empty(), "{} has no symbols of {crate_name}", program.display());
    functions
}

/// Part of the name of every vector instruction.
const VECTOR_INSTRUCTION: &str = "core_arch";

#[test]
#[cfg_attr(not(target_os = "linux"), ignore = "only symbol tables of Linux are known here")]
fn no_vector_instruction_is_called() {
    let mut called = local_functions(Path::new(env!("CARGO_BIN_EXE_iorect")), "iorect");
    called.retain(|function| function.contains(VECTOR_INSTRUCTION));
    assert!(
        called.is_empty(),
        "{} vector instructions are called as functions. A disassembler tells by which: all on the way from `KernelChoice::run` to an instruction \
         must be `#[inline(always)]`, and no closure.\n{}",
        called.len(),
        called.join("\n")
    );
}

/// The same look at this test's own program finds a call that is planted there.
#[test]
#[cfg_attr(
    not(all(target_os = "linux", target_arch = "x86_64")),
    ignore = "a call is planted only for x86-64 and Linux"
)]
fn a_planted_call_is_found() {
    #[cfg(target_arch = "x86_64")]
    std::hint::black_box(planted as fn(i64) -> i64);
    let program = std::env::current_exe().expect("the test knows its own path");
    let functions = local_functions(&program, env!("CARGO_CRATE_NAME"));
    assert!(functions.iter().any(|function| function.contains(VECTOR_INSTRUCTION)), "{functions:?}");
}

/// Uses AVX2, but is compiled for any processor.
// Reason: such is the fault that the test is for. It is never run.
#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code)]
fn planted(x: i64) -> i64 {
    use std::arch::x86_64::*;
    unsafe { _mm256_extract_epi64::<0>(_mm256_add_epi64(_mm256_set1_epi64x(x), _mm256_setzero_si256())) }
}
