//! Which functions an x86-64 Linux executable has, and what each of them calls.

use iced_x86::{
    Decoder, DecoderOptions, FlowControl, Instruction, InstructionInfoFactory, Mnemonic, OpKind, Register,
};
use object::{Object, ObjectSection, ObjectSymbol, RelocationTarget, SymbolKind};
use std::collections::BTreeMap;
use std::path::Path;

/// A function with its code.
pub(super) struct Function {
    /// Demangled, without hash.
    pub(super) name: String,
    address: u64,
    code: Vec<u8>,
}

/// What a call leads to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Target {
    /// A function of this name.
    Named(String),
    /// It is not known until run time; the address of the call.
    Unknown(u64),
}

/// The functions of an executable.
pub(super) struct Executable {
    functions: BTreeMap<u64, Function>,
    /// Names of what slots filled in by the dynamic loader point to, by address: the global offset table.
    slots: BTreeMap<u64, String>,
}

impl Executable {
    /// Reads an executable that was not stripped.
    pub(super) fn read(path: &Path) -> Executable {
        let data = std::fs::read(path).unwrap();
        let file = object::File::parse(&*data).unwrap();
        let mut functions = BTreeMap::new();
        for symbol in file.symbols().filter(|s| s.kind() == SymbolKind::Text && s.size() > 0) {
            let section = file.section_by_index(symbol.section_index().unwrap()).unwrap();
            let code = section.data_range(symbol.address(), symbol.size()).unwrap().unwrap_or_default();
            let name = demangle(symbol.name().unwrap());
            let function = Function { name, address: symbol.address(), code: code.to_vec() };
            functions.entry(function.address).or_insert(function);
        }
        assert!(!functions.is_empty(), "{} has no symbols: it was stripped", path.display());
        let slots = slots(&file, &functions);
        Executable { functions, slots }
    }

    /// All functions.
    pub(super) fn functions(&self) -> impl Iterator<Item = &Function> {
        self.functions.values()
    }

    /// What a function calls, jumps at the end of it included, in the order of its code.
    pub(super) fn calls(&self, function: &Function) -> Vec<Target> {
        let mut decoder = Decoder::with_ip(64, &function.code, function.address, DecoderOptions::NONE);
        let code: Vec<Instruction> = decoder.iter().collect();
        let inside = function.address..function.address + function.code.len() as u64;
        let mut calls = Vec::new();
        for (at, instruction) in code.iter().enumerate() {
            let target = match instruction.flow_control() {
                FlowControl::Call => self.named(instruction.near_branch_target()),
                FlowControl::UnconditionalBranch | FlowControl::ConditionalBranch => {
                    let target = instruction.near_branch_target();
                    if inside.contains(&target) {
                        continue;
                    }
                    self.named(target)
                }
                FlowControl::IndirectCall => self.indirect(&code[..at], instruction),
                FlowControl::IndirectBranch if is_jump_table(&code[..at], instruction) => continue,
                FlowControl::IndirectBranch => self.indirect(&code[..at], instruction),
                _ => continue,
            };
            calls.push(target.unwrap_or(Target::Unknown(instruction.ip())));
        }
        calls
    }

    /// The function at an address.
    fn named(&self, address: u64) -> Option<Target> {
        self.functions.get(&address).map(|function| Target::Named(function.name.clone()))
    }

    /// A call through the offset table, or through a register that was loaded from there.
    fn indirect(&self, before: &[Instruction], call: &Instruction) -> Option<Target> {
        match call.op0_kind() {
            OpKind::Register => self.held(before, call.op0_register()),
            _ => self.slot(call),
        }
    }

    /// What the slot of the offset table that an instruction reads points to.
    fn slot(&self, instruction: &Instruction) -> Option<Target> {
        let address = instruction.is_ip_rel_memory_operand().then(|| instruction.ip_rel_memory_address())?;
        self.slots.get(&address).map(|name| Target::Named(name.clone()))
    }

    /// The function whose address a register holds, by the last instruction before that writes it; followed through
    /// copies to other registers and to the stack.
    fn held(&self, before: &[Instruction], register: Register) -> Option<Target> {
        let at = before.iter().rposition(|i| writes(i, register))?;
        let (before, load) = (&before[..at], &before[at]);
        match (load.mnemonic(), load.op1_kind()) {
            (Mnemonic::Lea, _) if load.is_ip_rel_memory_operand() => self.named(load.ip_rel_memory_address()),
            (Mnemonic::Mov, OpKind::Register) => self.held(before, load.op1_register()),
            (Mnemonic::Mov, OpKind::Memory) if load.memory_base() == Register::RSP => {
                let at =
                    before.iter().rposition(|i| i.op0_kind() == OpKind::Memory && same_place(i, load))?;
                let stored = &before[at];
                let plain = stored.mnemonic() == Mnemonic::Mov && stored.op1_kind() == OpKind::Register;
                plain.then(|| self.held(&before[..at], stored.op1_register()))?
            }
            (Mnemonic::Mov, OpKind::Memory) => self.slot(load),
            _ => None,
        }
    }
}

fn same_place(a: &Instruction, b: &Instruction) -> bool {
    let place = |i: &Instruction| (i.memory_base(), i.memory_index(), i.memory_displacement64());
    place(a) == place(b)
}

/// `movsxd offset, [table + 4 * index]; add offset, table; jmp offset`: stays in the function.
fn is_jump_table(before: &[Instruction], jump: &Instruction) -> bool {
    let from = |i: &Instruction| i.mnemonic() == Mnemonic::Add && i.op0_register() == jump.op0_register();
    jump.op0_kind() == OpKind::Register
        && before.iter().rev().find(|i| writes(i, jump.op0_register())).is_some_and(from)
}

fn writes(instruction: &Instruction, register: Register) -> bool {
    let mut factory = InstructionInfoFactory::new();
    factory.info(instruction).used_registers().iter().any(|used| {
        use iced_x86::OpAccess::{CondWrite, ReadCondWrite, ReadWrite, Write};
        used.register().full_register() == register
            && matches!(used.access(), Write | CondWrite | ReadWrite | ReadCondWrite)
    })
}

/// Slots for functions of other libraries have a symbol, those for functions of this executable its address.
fn slots(file: &object::File, functions: &BTreeMap<u64, Function>) -> BTreeMap<u64, String> {
    let mut slots = BTreeMap::new();
    let imports = file.dynamic_symbol_table();
    for (address, relocation) in file.dynamic_relocations().into_iter().flatten() {
        use object::ObjectSymbolTable;
        let name = match relocation.target() {
            RelocationTarget::Symbol(index) => imports
                .as_ref()
                .and_then(|table| table.symbol_by_index(index).ok())
                .and_then(|symbol| symbol.name().ok().map(demangle)),
            _ => functions.get(&relocation.addend().cast_unsigned()).map(|function| function.name.clone()),
        };
        slots.extend(name.map(|name| (address, name)));
    }
    slots
}

/// The name without hash and version.
fn demangle(name: &str) -> String {
    let name = name.split('@').next().unwrap_or(name);
    format!("{:#}", rustc_demangle::demangle(name))
}
