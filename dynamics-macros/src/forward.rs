//! What the model's module offers, offered by the user's struct.
//!
//! The emitted module is read as Rust: its public constants become constants of the
//! struct, its functions of `(&Parameters<T>, …)` methods, its `impl System` the struct's.

use crate::expand::System;
use proc_macro2::TokenStream;
use quote::{ToTokens, quote};
use std::collections::{BTreeMap, BTreeSet};
use syn::punctuated::Punctuated;
use syn::visit_mut::{self, VisitMut};
use syn::{
    Attribute, FnArg, GenericParam, Ident, ImplItem, ImplItemFn, Item, ItemConst, ItemFn, ItemImpl,
    Lifetime, Path, Signature, Type, UseTree, Visibility, parse_quote,
};

/// The type with the parameters' values, in the emitted module.
const PARAMETERS: &str = "Parameters";

/// What is forwarded.
pub struct Forward {
    constants: Vec<ItemConst>,
    functions: Vec<ItemFn>,
    system: ItemImpl,
    /// The model's type in the module.
    model: Ident,
    names: Names,
}

impl Forward {
    /// Finds what a module offers; `None` if that is no system.
    pub fn of(file: &syn::File, system: &System<'_>) -> Option<Self> {
        let mut implementation = None;
        let (mut constants, mut functions) = (Vec::new(), Vec::new());
        let mut names = Names::new(system);
        for item in &file.items {
            names.learn(item);
            match item {
                Item::Const(item) if is_public(&item.vis) => constants.push(item.clone()),
                Item::Fn(item) if is_public(&item.vis) => functions.push(item.clone()),
                Item::Impl(item) if implements_system(item) => implementation = Some(item.clone()),
                _ => {}
            }
        }
        let implementation = implementation?;
        let model = head_of(&implementation.self_ty)?;
        Some(Self {
            constants,
            functions,
            system: implementation,
            model,
            names,
        })
    }

    /// The model's type, over the number type.
    pub fn model(&self, system: &System<'_>) -> TokenStream {
        let (module, model, scalar) = (system.module(), &self.model, system.scalar());
        quote!(#module::#model<#scalar>)
    }

    /// `impl System<T, …> for Cart<T>`
    pub fn implementation(&self, system: &System<'_>) -> TokenStream {
        let (generics, this, convert) = (system.generics(), system.this(), system.model());
        let (parameters, _, condition) = generics.split_for_impl();
        let model = self.model(system);
        let Some((path, _)) = &self.system.trait_ else {
            return TokenStream::new();
        };
        let path = self.names.qualified(path.clone(), VisitMut::visit_path_mut);
        let methods = self.methods().map(|method| {
            let signature = self.signature(&method.sig);
            let (name, arguments) = (&signature.ident, arguments(&signature));
            quote! {
                #[inline]
                #signature {
                    <#model as #path>::#name(&#convert(self) #(, #arguments)*)
                }
            }
        });
        quote! {
            impl #parameters #path for #this #condition {
                #(#methods)*
            }
        }
    }

    /// `impl Cart<T>`: constants, and the functions that `System` does not have.
    pub fn inherent(&self, system: &System<'_>, more: &TokenStream) -> TokenStream {
        let (generics, this) = (system.own_generics(), system.this());
        let (parameters, _, condition) = generics.split_for_impl();
        let taken: BTreeSet<String> = self.methods().map(|m| m.sig.ident.to_string()).collect();
        let constants = self.constants.iter().map(|constant| {
            let (docs, name, module) = (docs(&constant.attrs), &constant.ident, system.module());
            let ty = self
                .names
                .qualified((*constant.ty).clone(), VisitMut::visit_type_mut);
            quote!(#(#docs)* pub const #name: #ty = #module::#name;)
        });
        let functions = self.functions.iter();
        let functions = functions.filter(|f| !taken.contains(&f.sig.ident.to_string()));
        let functions = functions.map(|function| self.function(function, system));
        quote! {
            impl #parameters #this #condition {
                #more
                #(#constants)*
                #(#functions)*
            }
        }
    }

    /// A function of the module as a method.
    fn function(&self, function: &ItemFn, system: &System<'_>) -> TokenStream {
        let (docs, module, convert) = (docs(&function.attrs), system.module(), system.model());
        let mut signature = self.signature(&function.sig);
        if system.is_generic() {
            let scalar = system.scalar();
            let own = signature.generics.params.into_iter();
            signature.generics.params = own
                .filter(|p| !matches!(p, GenericParam::Type(p) if p.ident == scalar))
                .collect();
        }
        // The first argument is the parameters' values, which are in the struct.
        let of_parameters = function.sig.inputs.first().is_some_and(takes_parameters);
        let name = signature.ident.clone();
        if of_parameters {
            let own: FnArg = parse_quote!(&self);
            let others = signature.inputs.into_iter().skip(1);
            signature.inputs = std::iter::once(own).chain(others).collect();
        }
        let scalar = system.scalar();
        let arguments = arguments(&signature);
        let parameters = of_parameters.then(|| quote!(&#convert::<#scalar>(self).parameters,));
        quote! {
            #(#docs)*
            #[inline]
            pub #signature {
                #module::#name(#parameters #(#arguments),*)
            }
        }
    }

    fn methods(&self) -> impl Iterator<Item = &ImplItemFn> {
        self.system.items.iter().filter_map(|item| match item {
            ImplItem::Fn(method) => Some(method),
            _ => None,
        })
    }

    fn signature(&self, signature: &Signature) -> Signature {
        self.names
            .qualified(signature.clone(), VisitMut::visit_signature_mut)
    }
}

/// What the names of a module are from outside of it.
struct Names {
    /// Its own items and what it imports.
    known: BTreeMap<String, Path>,
    module: Ident,
    /// What `T` is called.
    scalar: Ident,
}

impl Names {
    fn new(system: &System<'_>) -> Self {
        Self {
            known: BTreeMap::new(),
            module: system.module(),
            scalar: system.scalar(),
        }
    }

    fn learn(&mut self, item: &Item) {
        let own = match item {
            Item::Const(item) => &item.ident,
            Item::Fn(item) => &item.sig.ident,
            Item::Struct(item) => &item.ident,
            Item::Enum(item) => &item.ident,
            Item::Type(item) => &item.ident,
            Item::Mod(item) => &item.ident,
            Item::Use(item) => {
                let start = Path {
                    leading_colon: item.leading_colon,
                    segments: Punctuated::new(),
                };
                return self.import(&item.tree, start);
            }
            _ => return,
        };
        let module = &self.module;
        let path = parse_quote!(#module::#own);
        self.known.insert(own.to_string(), path);
    }

    fn import(&mut self, tree: &UseTree, mut path: Path) {
        match tree {
            UseTree::Path(part) => {
                path.segments.push(part.ident.clone().into());
                self.import(&part.tree, path);
            }
            UseTree::Name(part) => {
                path.segments.push(part.ident.clone().into());
                self.known.insert(part.ident.to_string(), path);
            }
            UseTree::Rename(part) => {
                path.segments.push(part.ident.clone().into());
                self.known.insert(part.rename.to_string(), path);
            }
            UseTree::Group(group) => {
                for part in &group.items {
                    self.import(part, path.clone());
                }
            }
            UseTree::Glob(_) => {}
        }
    }

    /// A piece of the module as it is written outside of it.
    fn qualified<'a, P>(&'a self, mut piece: P, visit: impl Fn(&mut Outside<'a>, &mut P)) -> P {
        visit(&mut Outside(self), &mut piece);
        piece
    }
}

struct Outside<'a>(&'a Names);

impl VisitMut for Outside<'_> {
    fn visit_path_mut(&mut self, path: &mut Path) {
        visit_mut::visit_path_mut(self, path);
        if path.leading_colon.is_some() {
            return;
        }
        let Some(first) = path.segments.first() else {
            return;
        };
        if first.ident == "T" {
            if let Some(first) = path.segments.first_mut() {
                first.ident = self.0.scalar.clone();
            }
            return;
        }
        if let Some(known) = self.0.known.get(&first.ident.to_string()) {
            let mut whole = known.clone();
            if let Some(last) = whole.segments.last_mut() {
                last.arguments = first.arguments.clone();
            }
            whole.segments.extend(path.segments.iter().skip(1).cloned());
            *path = whole;
        }
    }

    fn visit_type_param_mut(&mut self, parameter: &mut syn::TypeParam) {
        visit_mut::visit_type_param_mut(self, parameter);
        if parameter.ident == "T" {
            parameter.ident = self.0.scalar.clone();
        }
    }

    /// Constants of a type must say what constants of a module need not.
    fn visit_type_reference_mut(&mut self, reference: &mut syn::TypeReference) {
        visit_mut::visit_type_reference_mut(self, reference);
        let is_text = reference.elem.to_token_stream().to_string() == "str";
        if is_text && reference.lifetime.is_none() {
            let place = proc_macro2::Span::call_site();
            reference.lifetime = Some(Lifetime::new("'static", place));
        }
    }
}

fn is_public(visibility: &Visibility) -> bool {
    matches!(visibility, Visibility::Public(_))
}

fn implements_system(item: &ItemImpl) -> bool {
    let path = item.trait_.as_ref().map(|(path, _)| path);
    path.and_then(|path| path.segments.last())
        .is_some_and(|last| last.ident == "System")
}

/// The last name of a type's path.
fn head_of(ty: &Type) -> Option<Ident> {
    match ty {
        Type::Path(path) => path.path.segments.last().map(|last| last.ident.clone()),
        Type::Reference(reference) => head_of(&reference.elem),
        _ => None,
    }
}

fn takes_parameters(argument: &FnArg) -> bool {
    matches!(argument, FnArg::Typed(argument)
        if head_of(&argument.ty).is_some_and(|head| head == PARAMETERS))
}

/// The arguments behind `self`, to be handed on.
fn arguments(signature: &Signature) -> Vec<TokenStream> {
    let typed = signature
        .inputs
        .iter()
        .filter_map(|argument| match argument {
            FnArg::Typed(argument) => Some(argument.pat.to_token_stream()),
            FnArg::Receiver(_) => None,
        });
    typed.collect()
}

fn docs(attributes: &[Attribute]) -> Vec<&Attribute> {
    let docs = attributes.iter().filter(|a| a.path().is_ident("doc"));
    docs.collect()
}
